//! The figures that a wish is about.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use crate::Field;
use crate::design::sphere::caps_overlap_sr;
use crate::design::{BothEyes, Circle, DesignError, Mount, Pencil, Section};

/// A figure that can be wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// Elevation of the design plane: the tendency to look up.
    Zeta,
    /// Direction of greatest overlap in the image.
    Xi,
    /// Overlap on the design plane.
    Phi,
    /// Whole field on the design plane.
    Total,
    /// Overlap ahead on the horizontal plane.
    Front,
    /// How far the field reaches around on the horizontal plane.
    Outer,
    /// Share of the sphere that is seen.
    Seen,
    /// Share of the sphere that both eyes see.
    Both,
}

/// What is to be as great as can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// The field on the design plane: `max 2 theta - phi` (Eq. 1).
    TotalField,
    /// The share of the sphere that is seen.
    SphereSeen,
    /// The share of the sphere that both eyes see.
    SphereBoth,
    /// What a lens may lose before the horizontal view ahead has a gap.
    Margin,
}

/// All figures of a mount and lens. Angles in rad, shares 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Elevation of the design plane.
    pub zeta_rad: f64,
    /// Direction of greatest overlap in the image.
    pub xi_rad: f64,
    /// Overlap on the design plane, negative for a gap.
    pub phi_rad: f64,
    /// Whole field on the design plane.
    pub total_rad: f64,
    /// Overlap ahead on the horizontal plane, negative for a gap.
    pub front_rad: f64,
    /// How far the field reaches around on the horizontal plane.
    pub outer_rad: f64,
    /// Share of the sphere that is seen.
    pub seen: f64,
    /// Share of the sphere that both eyes see.
    pub both: f64,
    /// What a lens may lose of its whole field before the horizontal view ahead has a gap.
    pub margin_rad: f64,
}

impl Goal {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Zeta,
        Self::Xi,
        Self::Phi,
        Self::Total,
        Self::Front,
        Self::Outer,
        Self::Seen,
        Self::Both,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Zeta => "zeta",
            Self::Xi => "xi",
            Self::Phi => "phi",
            Self::Total => "total",
            Self::Front => "front",
            Self::Outer => "outer",
            Self::Seen => "seen",
            Self::Both => "both",
        }
    }

    /// Whether it is a share of the sphere rather than an angle.
    pub fn is_share(self) -> bool {
        matches!(self, Self::Seen | Self::Both)
    }

    /// Its value in degrees, or as a share.
    pub fn shown(self, value: f64) -> f64 {
        match self.is_share() {
            true => value,
            false => value.to_degrees(),
        }
    }

    /// What can be wanted, degrees or shares, and that in words.
    pub(super) fn range(self) -> (RangeInclusive<f64>, &'static str) {
        match self {
            Self::Zeta | Self::Xi => (-180.0..=180.0, "-180 to 180 degrees"),
            Self::Phi | Self::Front => (-180.0..=360.0, "-180, a gap, to 360 degrees"),
            Self::Total | Self::Outer => (0.0..=360.0, "0 to 360 degrees"),
            Self::Seen | Self::Both => (0.0..=1.0, "a share, 0 to 1"),
        }
    }
}

impl Objective {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::TotalField,
        Self::SphereSeen,
        Self::SphereBoth,
        Self::Margin,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::TotalField => "total-field",
            Self::SphereSeen => "sphere-seen",
            Self::SphereBoth => "sphere-both",
            Self::Margin => "margin",
        }
    }

    /// Its value, rad or a share.
    pub fn value(self, figures: &Figures) -> f64 {
        match self {
            Self::TotalField => figures.total_rad.min(TAU),
            Self::SphereSeen => figures.seen,
            Self::SphereBoth => figures.both,
            Self::Margin => figures.margin_rad,
        }
    }

    /// What candidates are compared by: the value, and the sphere seen where that is equal.
    pub(super) fn score(self, figures: &Figures) -> f64 {
        self.value(figures) + 1e-4 * figures.seen
    }
}

impl Figures {
    /// Of circular fields of half-angle `half_rad`, in closed forms that go on smoothly where the
    /// figures themselves end: beyond a turn, for instance. NaN where there is none.
    pub(super) fn smooth(mount: &Mount, half_rad: f64) -> Self {
        let (theta_rad, between) = (2.0 * half_rad, mount.between_axes_rad());
        let horizontal = Pencil::of(mount, half_rad, 0.0);
        let of = |value: fn(&Pencil) -> f64| horizontal.as_ref().map_or(f64::NAN, value);
        let both = caps_overlap_sr(half_rad, half_rad, between) / (2.0 * TAU);
        Self {
            zeta_rad: mount.zeta_rad(),
            xi_rad: mount.xi_rad(),
            phi_rad: theta_rad - between,
            total_rad: (theta_rad + between).min(2.0 * theta_rad),
            front_rad: of(Pencil::front_overlap_rad),
            outer_rad: of(Pencil::outer_rad),
            seen: 1.0 - libm::cos(half_rad) - both,
            both,
            margin_rad: theta_rad - mount.horizontal_split_rad(),
        }
    }

    /// The same by the forward form.
    pub(super) fn forward(mount: &Mount, half_rad: f64) -> Result<Self, DesignError> {
        let theta = DesignError::Theta(2.0 * half_rad.to_degrees());
        let field = Field::new(vec![half_rad]).map_err(|_| theta)?;
        let eyes = BothEyes::of_mount(mount, &field);
        let design = Section::of(&eyes, &Circle::design(mount));
        let horizontal = Section::of(&eyes, &Circle::horizontal());
        let shares = eyes.shares();
        Ok(Self {
            zeta_rad: mount.zeta_rad(),
            xi_rad: mount.xi_rad(),
            phi_rad: design.front_overlap_rad(),
            total_rad: design.seen_rad(),
            front_rad: horizontal.front_overlap_rad(),
            outer_rad: horizontal.outer_rad(),
            seen: shares.seen(),
            both: shares.both,
            margin_rad: 2.0 * half_rad - mount.horizontal_split_rad(),
        })
    }

    /// One of them, rad or a share.
    pub fn get(&self, goal: Goal) -> f64 {
        match goal {
            Goal::Zeta => self.zeta_rad,
            Goal::Xi => self.xi_rad,
            Goal::Phi => self.phi_rad,
            Goal::Total => self.total_rad,
            Goal::Front => self.front_rad,
            Goal::Outer => self.outer_rad,
            Goal::Seen => self.seen,
            Goal::Both => self.both,
        }
    }
}
