//! From a mount and its lenses to everything that can be said about what they see.

use nalgebra::Vector3;

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
    /// What a lens may lose of its whole field, by refraction or a hull that hides its rim, before
    /// there is a gap straight ahead, and in the middle of the design plane, rad; negative where
    /// there is one.
    pub margins_rad: [f64; 2],
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
        let design = Circle::through(&axes.0, &axes.1)?;
        Ok(Self {
            mount,
            theta_rad,
            paper: mount.paper_form(theta_rad),
            between_axes_rad: angle_between(&axes.0, &axes.1),
            design: Section::of(eyes, &design),
            horizontal: Section::of(eyes, &Circle::horizontal()),
            shares: eyes.shares(),
            blind_zones: eyes.blind_zones(),
            margins_rad: [Vector3::x(), design.direction(0.0)].map(|ahead| {
                let rooms = [&eyes.left, &eyes.right].map(|eye| eye.room_rad(&ahead));
                2.0 * rooms[0].min(rooms[1])
            }),
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
}
