//! What the boards say, put into the rig.

use nalgebra::{Rotation3, Vector3};
use tectum_optics::{Pose, RgbCurves, Rig, RigError, StitchingFile};

use super::{Alignment, OwnScale, TurnAbout};
use crate::align::Warp;
use crate::seam::shares_png;

/// What of the alignment a rig takes over.
#[derive(Debug, Clone, PartialEq)]
pub enum Correction {
    /// The turn of both eyes: for calibrated eyes.
    Turn,
    /// The turn, and a bend of the picture by the boards' own scale: for eyes that are not.
    Scale(OwnScale),
}

/// A rig put right, and the pictures that its `[stitching]` then holds.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// The rig without `[stitching]`.
    pub rig: Rig,
    /// Shares of the left eye as a PNG file, if the rig had any.
    pub seam_png: Option<Vec<u8>>,
    /// Curves, if the rig had any.
    pub tone: Option<[RgbCurves; 2]>,
    /// Bend, if the rig had one or the scale makes one.
    pub warp: Option<Warp>,
}

impl Alignment {
    /// The scale of its own that the boards give, turn and bend. `None` if nothing can be solved.
    pub fn own_scale(&self) -> Option<OwnScale> {
        OwnScale::fit(&self.corners, &self.turned.turn)
    }
}

/// The rig with its eyes turned as the boards say, and the pictures of its `[stitching]`, which are of
/// the body's directions, turned with them; with [`Correction::Scale`] bent as well.
///
/// # Errors
/// [`RigError`] if the turned rig is not allowed.
pub fn corrected(
    rig: &Rig,
    found: &Alignment,
    correction: &Correction,
    seam_px: [u16; 2],
) -> Result<Corrected, RigError> {
    let turn = &found.turned.turn;
    let pose = |eye: &Option<tectum_optics::RigEye>| {
        let still = Pose {
            rotation: Rotation3::identity(),
            position_m: Vector3::zeros(),
        };
        eye.as_ref().map_or(still, |eye| Pose {
            rotation: turn * eye.pose.rotation,
            position_m: match found.turned.about {
                TurnAbout::Body => turn * eye.pose.position_m,
                TurnAbout::Eyes => eye.pose.position_m,
            },
        })
    };
    let mut turned = rig.with_poses([pose(&rig.left), pose(&rig.right)])?;
    turned = turned.with_stitching(Default::default(), StitchingFile::default());
    // The direction of the old picture that is now shown in a direction.
    let old = |shown: &Vector3<f64>| match correction {
        Correction::Turn => turn.inverse() * shown,
        Correction::Scale(scale) => scale.shown(shown),
    };
    let had = rig.stitching.as_ref();
    let seam = had.and_then(|stitching| stitching.seam.as_ref());
    let warp = had.and_then(|stitching| stitching.warp.as_ref());
    let bends = warp.is_some() || matches!(correction, Correction::Scale(_));
    let bent = |shown: &Vector3<f64>| {
        let old = old(shown);
        [0, 1].map(|eye| turn * warp.map_or(old, |warp| warp.bent(eye, &old)))
    };
    Ok(Corrected {
        rig: turned,
        seam_png: seam.and_then(|seam| shares_png(seam_px, |d| seam.left_share(&old(d))).ok()),
        tone: had.and_then(|stitching| stitching.tone),
        warp: bends.then(|| Warp::of(bent)).flatten(),
    })
}
