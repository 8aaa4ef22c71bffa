//! Whether the meshes of output pictures carry a bend.

use rayon::prelude::*;
use tectum_bake::{BakeOptions, mesh_bytes};
use tectum_optics::{Rig, Stitching};

use super::{AlignError, Warp};
use crate::seam::Seam;

/// Meshes may cost this many times what they cost without the bend: no finer step, but a few cells
/// more where a seam runs elsewhere.
const MAX_GROWTH: f64 = 1.05;
/// Share of the error that a bent mesh may have: [`mesh_bytes`] looks at few pixels, and the final
/// seam differs a little.
const ERROR_SHARE: f64 = 0.9;

/// The output pictures, and what their meshes cost without a bend.
pub(super) struct Carrier {
    rig: Rig,
    plain: Vec<(BakeOptions, usize)>,
}

impl Carrier {
    /// For a rig without a bend, cut along `seam`.
    pub fn new(rig: &Rig, seam: &Seam, outputs: &[BakeOptions]) -> Result<Self, AlignError> {
        let [width, _] = seam.overlap.size_px.map(|px| px as u16);
        let mut rig = rig.clone();
        rig.stitching = Some(Stitching {
            seam: Some(seam.shares.seam_map([width, width / 2])?),
            ..Stitching::default()
        });
        let plain = outputs
            .par_iter()
            // A picture that no mesh serves is no reason against a bend.
            .filter_map(|output| Some((*output, mesh_bytes(&rig, output)?)))
            .collect();
        Ok(Self { rig, plain })
    }

    /// Whether every picture's mesh carries the bend at its error and its bytes.
    pub fn carries(&self, warp: &Warp) -> bool {
        let mut rig = self.rig.clone();
        if let (Some(stitching), Ok(map)) = (&mut rig.stitching, warp.map()) {
            stitching.warp = Some(map);
        }
        self.plain.par_iter().all(|(output, plain)| {
            let stricter = BakeOptions {
                max_error_px: output.max_error_px * ERROR_SHARE,
                ..*output
            };
            mesh_bytes(&rig, &stricter)
                .is_some_and(|bytes| bytes as f64 <= MAX_GROWTH * *plain as f64)
        })
    }
}
