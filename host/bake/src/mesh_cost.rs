//! What the meshes of a rig cost, from few pixels: to choose a bend by, many times over.

use rayon::prelude::*;
use tectum_optics::{OutputMap, Rig};

use crate::bake::{BakeOptions, STEPS_LOG2, margin_px, trace};
use crate::mesh::{Targets, fit};
use crate::rows::RunRule;
use crate::seam::SEAM_MAP_TOLERANCE;
use crate::sights::{Seam, Sights};

/// Step of the mesh that is tried on fewer pixels, as a power of two: the finest there is.
const TRIED_STEP_LOG2: u32 = 3;

/// Bytes of both eyes' meshes in a table of the rig, or `None` if no mesh meets the error.
///
/// A mesh with a vertex every 32 px of a picture has the same vertices as one with a vertex every
/// 8 px of a picture a quarter as wide, so it is fitted to that. Seen at fewer pixels the error comes out
/// a little less, by a few hundredths of itself; the bytes are those of the table but for a mesh
/// that is right at the limit.
pub fn mesh_bytes(rig: &Rig, options: &BakeOptions) -> Option<usize> {
    let of_eye = |eye: usize, targets: &Targets<'_>| {
        let source = [&rig.left, &rig.right][eye].as_ref()?.eye.size_px;
        match fit(targets, source, TRIED_STEP_LOG2, options.max_error_px) {
            Ok(None) => Some(0),
            Ok(Some(mesh)) if mesh.max_error_px <= options.max_error_px => {
                Some(mesh.data.to_bytes().len())
            }
            _ => None,
        }
    };
    let mut bytes = [0, 1].map(|eye: usize| [&rig.left, &rig.right][eye].is_none().then_some(0));
    for step_log2 in STEPS_LOG2 {
        let fewer = with_larger_pixels(&options.output, step_log2 - TRIED_STEP_LOG2);
        let seam = Seam::of(rig, options.feather_rad);
        let sights = Sights::new(rig, &fewer, seam, margin_px(options));
        let (_, targets) = trace(&sights, RunRule::exact(SEAM_MAP_TOLERANCE));
        let found: Vec<Option<usize>> = (0..2)
            .into_par_iter()
            .map(|eye| bytes[eye].or_else(|| of_eye(eye, &targets[eye])))
            .collect();
        bytes = [found[0], found[1]];
        if let [Some(left), Some(right)] = bytes {
            return Some(left + right);
        }
    }
    None
}

/// The picture with pixels 2^`log2` times as wide and high, the last ones in part beyond its border.
fn with_larger_pixels(map: &OutputMap, log2: u32) -> OutputMap {
    let times = 1u16 << log2;
    let axis = |[first, step]: [f64; 2]| {
        let step_of_all = step * f64::from(times);
        [first + (step_of_all - step) / 2.0, step_of_all]
    };
    OutputMap {
        size_px: map.size_px.map(|side| side.div_ceil(times)),
        u: axis(map.u),
        v: axis(map.v),
        ..*map
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake;
    use tectum_optics::Projection;

    #[test]
    fn the_bytes_are_those_of_the_baked_table() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tables/rigs/paper-fish.toml"
        );
        let rig = Rig::load(path.as_ref()).unwrap();
        for size_px in [[320, 160], [640, 320]] {
            let options = BakeOptions {
                output: Projection::Equirect.output_map(size_px).unwrap(),
                max_error_px: 0.05,
                feather_rad: 4f64.to_radians(),
            };
            let baked = bake(&rig, &options).unwrap().report.bytes;
            let meshes = baked.mesh_left + baked.mesh_right;
            // A column of cells more or less at the border of what each eye shows.
            let found = mesh_bytes(&rig, &options).unwrap();
            assert!(found.abs_diff(meshes) * 20 <= meshes, "{found} {meshes}");
            let impossible = BakeOptions {
                max_error_px: 0.004,
                ..options
            };
            assert_eq!(mesh_bytes(&rig, &impossible), None);
        }
    }
}
