//! What happens to a sampled value: written, or blended over the left eye's value.

use tectum_tables::Ramp;

use super::arithmetic::blend;

/// Takes the channel values of a pixel, then steps to the next pixel.
pub(crate) trait Sink {
    /// New value of a channel that held `old`.
    fn mix(&self, old: u32, new: u32) -> u32;
    /// Moves on to the next pixel.
    fn step(&mut self);
}

/// Replaces the old value.
pub(crate) struct Write;

impl Sink for Write {
    #[inline(always)]
    fn mix(&self, _old: u32, new: u32) -> u32 {
        new
    }

    #[inline(always)]
    fn step(&mut self) {}
}

/// Blends the right eye's value over the left eye's, which is already there.
pub(crate) struct Blend(pub(crate) Ramp);

impl Sink for Blend {
    #[inline(always)]
    fn mix(&self, old: u32, new: u32) -> u32 {
        blend(old, new, self.0.left_weight())
    }

    #[inline(always)]
    fn step(&mut self) {
        self.0.step();
    }
}
