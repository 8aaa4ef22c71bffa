//! What baking takes beside the table.

use crate::bake::STEPS_LOG2;
use crate::mesh::KEPT_BYTES;
use crate::rows::MAX_HELD_ROWS;

/// Bytes of a traced pixel: two positions, the left eye's weight and its range.
const TRACED_BYTES: usize = 56;
/// Bytes of a position.
const POSITION_BYTES: usize = 16;
/// A mesh beside its cells' vertices: the apron.
const APRON: usize = 3;

/// Bytes of memory that [`bake`](crate::bake()) takes for an output of `size_px`, about, with meshes of
/// the coarsest step: positions, up to a bound (32 MB an eye); rows that are traced at a time, 4 KB for
/// each pixel of the width; and the equations of both meshes, where each eye shows something from border
/// to border. Equations grow with the picture's longer side and the square of its shorter one:
/// 107 MB an eye at 8192x4096. Each finer step takes eight times as much, and is tried only where a
/// coarser one does not do.
pub fn memory_bytes(size_px: [u16; 2]) -> usize {
    let [width, height] = size_px.map(usize::from);
    let kept = (width * height * POSITION_BYTES).min(2 * KEPT_BYTES);
    let traced = MAX_HELD_ROWS.min(height) * width * TRACED_BYTES;
    let vertices = [width, height].map(|side| side.div_ceil(1 << STEPS_LOG2[0]) + APRON);
    // A pixel ties four vertices of a row, in four rows.
    let band = APRON * vertices[0].min(vertices[1]) + APRON + 1;
    let equations = 2 * vertices[0] * vertices[1] * band * size_of::<f64>();
    kept + traced + equations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_picture_takes_some_hundred_megabytes() {
        let megabytes = |size_px| memory_bytes(size_px) / 1_000_000;
        assert!(megabytes([640, 320]) < 10);
        assert!(megabytes([2048, 1024]) < 60);
        assert!(megabytes([8192, 4096]) < 320);
        assert!(megabytes([8192, 8192]) < 1000);
    }
}
