//! Catmull-Rom upsampling of a mesh in exact integers.
//!
//! With S = 2^s pixels to a cell and k the pixel inside it, the cubic through four values
//! p0..p3 (Catmull & Rom 1974, tension 1/2), taken at t = k/S relative to p1, is
//!
//! ```text
//! 2 S^3 (p - p1) = A1 S^2 k + A2 S k^2 + A3 k^3
//! A1 = p2 - p0,  A2 = 2 p0 - 5 p1 + 4 p2 - p3,  A3 = 3 (p1 - p2) + p3 - p0
//! ```
//!
//! an integer, so stepping by forward differences equals direct evaluation bit for bit. In terms
//! of differences of neighbours it is at most their greatest magnitude: the weights' magnitudes
//! add up to t + t^2 - t^3 <= 1. That bound is what keeps everything here inside an `i32`.

use crate::in_order::in_order;

/// Greatest difference in x or y between neighbouring vertices: 100 px in Q8.
///
/// A row value is a convex-plus-overshoot mix of four vertices with weights of total magnitude at
/// most 1.25, so neighbouring row values differ by at most 1.25 x 25,600 + 1 = 32,001; scaled by
/// 2^16, with a fraction below 2^24 and rounding of 2^15 + 2^23 added, that stays below 2^31.
pub const MAX_VERTEX_DIFFERENCE_Q8: i32 = 25_600;

/// Bits after the binary point of an [`Offset`]: a Q8 position with 16 more bits, which
/// is what the exact cubic of the largest step (32 = 2^5: 2 S^3 = 2^16) needs.
pub(crate) const ACCUMULATOR_BITS: u32 = 24;
/// Largest step: `2 * 32^3` is the 2^16 that [`ACCUMULATOR_BITS`] leaves.
pub(crate) const MAX_STEP_LOG2: u32 = 5;

/// Vertical half of the upsampling: weights of one output row, shared by all vertex columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowWeights {
    /// Weights of the three neighbour differences, times 2 S^3.
    weights: [i32; 3],
    /// From vertex units times 2 S^3 to Q8.
    shift: u32,
    /// From vertex units to Q8.
    vertex_shift: u32,
}

impl RowWeights {
    /// Weights at `k` (0..S) for a step of 2^`step_log2` and vertices in Q`fraction_bits`.
    #[inline]
    pub(crate) fn new(k: i32, step_log2: u32, fraction_bits: u32) -> Self {
        let step = 1 << step_log2;
        let w0 = k * (step - k) * (step - k);
        let w3 = -k * k * (step - k);
        let vertex_shift = 8 - fraction_bits;
        Self {
            weights: [w0, k * (step * step + 3 * step * k - 2 * k * k), w3],
            shift: 3 * step_log2 + 1 - vertex_shift,
            vertex_shift,
        }
    }

    /// Weights, and the shifts to Q8 of their sum and of a vertex.
    pub(crate) fn parts(&self) -> ([i32; 3], u32, u32) {
        (self.weights, self.shift, self.vertex_shift)
    }

    /// Row value in Q8 from four vertices of one column, top to bottom; rounds half up.
    #[inline(always)]
    pub(crate) fn apply(&self, v: [i16; 4]) -> i32 {
        let [v0, v1, v2, v3] = v.map(i32::from);
        let [w0, w1, w2] = self.weights;
        let sum = w0
            .wrapping_mul(v1 - v0)
            .wrapping_add(w1.wrapping_mul(v2 - v1))
            .wrapping_add(w2.wrapping_mul(v3 - v2));
        let half = 1 << (self.shift - 1);
        (v1 << self.vertex_shift) + (sum.wrapping_add(half) >> self.shift)
    }
}

/// Signed distance from an [`Axis`]'s whole-pixel base to a position, px in Q24.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Offset(i32);

impl Offset {
    /// Whole pixels, rounded down: -128..=127.
    #[inline(always)]
    pub fn px(self) -> i32 {
        self.0 >> ACCUMULATOR_BITS
    }

    /// What is left over, in Q8: 0..=255.
    #[inline(always)]
    pub fn fraction_q8(self) -> u32 {
        (self.0 as u32 >> 16) & 255
    }
}

/// Steps one coordinate of the source position through the pixels of a cell, by forward
/// differences of its cubic.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    base_px: i32,
    offset: Offset,
    difference: [i32; 3],
}

impl Axis {
    /// Axis at the start of a cell with row values `p` in Q8, relative to `origin_px`.
    #[inline(always)]
    pub(crate) fn new(p: [i32; 4], origin_px: i32, step_log2: u32) -> Self {
        let [p0, p1, p2, p3] = p;
        let a1 = p2.wrapping_sub(p0);
        let a3 = 3i32
            .wrapping_mul(p1.wrapping_sub(p2))
            .wrapping_add(p3)
            .wrapping_sub(p0);
        // The cubic passes through p2 at t = 1: A1 + A2 + A3 = 2 (p2 - p1).
        let a2 = p2
            .wrapping_sub(p1)
            .wrapping_mul(2)
            .wrapping_sub(a1)
            .wrapping_sub(a3);
        // Scaled from 2 S^3 to 2^16, so that every step shares one binary point.
        let c1 = a1.wrapping_shl(15 - step_log2);
        let c2 = a2.wrapping_shl(15 - 2 * step_log2);
        let c3 = a3.wrapping_shl(15 - 3 * step_log2);
        Self {
            base_px: origin_px + (p1 >> 8),
            offset: Offset(((p1 & 255) << 16).wrapping_add(1 << 15)),
            difference: [
                c1.wrapping_add(c2).wrapping_add(c3),
                c2.wrapping_mul(2).wrapping_add(c3.wrapping_mul(6)),
                c3.wrapping_mul(6),
            ],
        }
    }

    /// Whole pixels of the cell's start; add [`Axis::offset`] for the position.
    #[inline(always)]
    pub fn base_px(&self) -> i32 {
        self.base_px
    }

    /// From [`Axis::base_px`] to the position of the present pixel.
    #[inline(always)]
    pub fn offset(&self) -> Offset {
        self.offset
    }

    /// Position in Q8 pixels.
    #[inline(always)]
    pub fn position_q8(&self) -> i32 {
        (self.base_px << 8) + (self.offset.0 >> 16)
    }

    /// The same axis moved on by half a pixel, so that [`Offset::px`] rounds to nearest.
    #[inline(always)]
    pub fn rounding_to_nearest(mut self) -> Self {
        self.offset.0 = self.offset.0.wrapping_add(1 << (ACCUMULATOR_BITS - 1));
        self
    }

    /// Moves on to the next output pixel.
    #[inline(always)]
    pub fn step(&mut self) {
        let [d1, d2, d3] = self.difference;
        self.offset.0 = self.offset.0.wrapping_add(d1);
        self.difference = [
            in_order(d1.wrapping_add(d2)),
            in_order(d2.wrapping_add(d3)),
            d3,
        ];
    }
}

/// Neighbouring output pixels of one row that lie in one mesh cell.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Number of output pixels: 1..=S.
    pub len: u32,
    /// Source x, at the first pixel.
    pub x: Axis,
    /// Source y, at the first pixel.
    pub y: Axis,
}

impl Segment {
    /// Moves both axes on to the next output pixel.
    #[inline(always)]
    pub fn step(&mut self) {
        self.x.step();
        self.y.step();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Catmull-Rom in f64, straight from the definition.
    fn catmull_rom(p: [f64; 4], t: f64) -> f64 {
        let [p0, p1, p2, p3] = p;
        0.5 * (2.0 * p1
            + (p2 - p0) * t
            + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t * t
            + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t * t * t)
    }

    /// Four values whose neighbours differ by at most `limit`.
    fn chain(limit: i32) -> impl Strategy<Value = [i32; 4]> {
        (-200_000i32..200_000, prop::array::uniform3(-limit..=limit)).prop_map(|(start, d)| {
            let mut p = [start; 4];
            for i in 1..4 {
                p[i] = p[i - 1] + d[i - 1];
            }
            p
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// Forward differences equal the f64 cubic to the bit, at the largest allowed jumps too.
        #[test]
        fn stepping_equals_direct_evaluation(p in chain(32_001), s in 3u32..=5, k0 in 0i32..32) {
            let step = 1 << s;
            let k0 = k0 % step;
            let mut axis = Axis::new(p, 7, s);
            for _ in 0..k0 {
                axis.step();
            }
            for k in k0..step {
                let exact = catmull_rom(p.map(f64::from), f64::from(k) / f64::from(step));
                prop_assert_eq!(axis.position_q8(), 7 * 256 + (exact + 0.5).floor() as i32);
                let whole = axis.base_px() + axis.offset().px();
                prop_assert_eq!(whole * 256 + axis.offset().fraction_q8() as i32, axis.position_q8());
                prop_assert_eq!(
                    axis.rounding_to_nearest().offset().px() + axis.base_px(),
                    (axis.position_q8() + 128) >> 8
                );
                axis.step();
            }
        }

        #[test]
        fn row_values_equal_direct_evaluation(
            start in -6_000i32..6_000, d in prop::array::uniform3(-6_400i32..=6_400),
            s in 3u32..=5, k in 0i32..32, q in 4u32..=8,
        ) {
            let k = k % (1 << s);
            // The limit holds in Q8, whatever the vertices' own fraction.
            let d = d.map(|d| (d << 2) >> (8 - q));
            let mut v = [start as i16; 4];
            for i in 1..4 {
                let next = i32::from(v[i - 1]) + d[i - 1];
                v[i] = next.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
            }
            let exact = catmull_rom(v.map(f64::from), f64::from(k) / f64::from(1 << s));
            let q8 = exact * f64::from(1 << (8 - q));
            // The p1 part is exact, so rounding the sum is rounding the relative part.
            prop_assert_eq!(RowWeights::new(k, s, q).apply(v), (q8 + 0.5).floor() as i32);
        }
    }

    #[test]
    fn the_first_pixel_of_a_cell_is_its_vertex() {
        let axis = Axis::new([0, 1000, 3000, 4000], 0, 4);
        assert_eq!(axis.position_q8(), 1000);
        assert_eq!(RowWeights::new(0, 4, 6).apply([5, 7, 11, 13]), 7 << 2);
    }
}
