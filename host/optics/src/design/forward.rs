//! From a mount and its lenses to everything that can be said about what they see.

use std::f64::consts::TAU;

use super::{BlindZone, BothEyes, Circle, DesignError, Mount, PaperForm, Section, Shares};
use crate::convention::angle_between;

/// What a mount and its lenses see.
#[derive(Debug, Clone, PartialEq)]
pub struct Forward {
    /// The mount, or the one that comes nearest to both eyes of a rig.
    pub mount: Mount,
    /// Whole field of a lens, where it is widest, rad.
    pub theta_rad: f64,
    /// The paper's figures for the same angles.
    pub paper: PaperForm,
    /// Angle between the optical axes, rad.
    pub between_axes_rad: f64,
    /// The design plane: through both optical axes.
    pub design: Section,
    /// The horizontal plane.
    pub horizontal: Section,
    /// Shares of the sphere.
    pub shares: Shares,
    /// What neither eye sees, the largest first.
    pub blind_zones: Vec<BlindZone>,
}

impl Forward {
    /// For two eyes. All but the paper's form also holds where they are not the same on both sides.
    ///
    /// # Errors
    /// [`DesignError`] if no mount is near, or there is no design plane.
    pub fn of(eyes: &BothEyes) -> Result<Self, DesignError> {
        let axes = (eyes.left.axis(), eyes.right.axis());
        let mount = Mount::from_axes(&axes.0, &axes.1)?;
        let theta_rad = eyes.theta_rad();
        Ok(Self {
            mount,
            theta_rad,
            paper: mount.paper_form(theta_rad),
            between_axes_rad: angle_between(&axes.0, &axes.1),
            design: Section::of(eyes, &Circle::through(&axes.0, &axes.1)?),
            horizontal: Section::of(eyes, &Circle::horizontal()),
            shares: eyes.shares(),
            blind_zones: eyes.blind_zones(),
        })
    }

    /// Overlap on the design plane, rad: theta less the angle between the axes; negative for a gap.
    pub fn phi_rad(&self) -> f64 {
        self.design.front_overlap_rad()
    }

    /// Whole field on the design plane, rad: 2 theta less the overlap, at most a turn.
    pub fn theta_total_rad(&self) -> f64 {
        self.design.seen_rad()
    }

    /// What a lens may lose of its whole field, by refraction or a hull that hides its rim, before
    /// the horizontal view ahead and the design plane have a gap, rad; negative where they have.
    pub fn margins_rad(&self) -> [f64; 2] {
        [self.mount.horizontal_split_rad(), self.between_axes_rad]
            .map(|split| self.theta_rad - split)
    }

    /// Share of the horizon that is seen, 0 to 1.
    pub fn horizon_share(&self) -> f64 {
        self.horizontal.seen_rad() / TAU
    }
}
