//! Follows the drift of one eye's exposure against the other's, in integers.
//!
//! Off unless called. Each frame, or each few: [`Meter::read`] both eyes, [`Exposure::update`],
//! [`crate::Tone::set`] with [`Exposure::gains`]. What is measured does not depend on the gains
//! in use, so nothing can swing. `FORMAT.md`, "Exposure", has every rounding.
//!
//! ```no_run
//! use tectum_core::{Exposure, Frame, Gray8, Meter, Sampler, StitchError, Stitcher, Tables, Tone};
//! # use tectum_core::Eye;
//! # fn next() -> [Frame<'static, Gray8>; 2] { unimplemented!() }
//!
//! fn run(tables: &Tables<'_>, row: &mut [u8], send: fn(&[u8])) -> Result<(), StitchError> {
//!     let (mut meter, mut exposure) = (Meter::new(), Exposure::new(Exposure::USUAL_RATE));
//!     let mut tone = Tone::new(tables, exposure.gains());
//!     loop {
//!         let [left, right] = next();
//!         meter.read(tables, Eye::Left, &left)?;
//!         meter.read(tables, Eye::Right, &right)?;
//!         if exposure.update(&meter) {
//!             tone.set(tables, exposure.gains());
//!         }
//!         let stitcher = Stitcher::new(tables, Sampler::Bilinear)?.with_tone(&tone);
//!         for y in 0..tables.output_height_px() {
//!             stitcher.row(&left, &right, y, row)?;
//!             send(row);
//!         }
//!     }
//! }
//! ```

use tectum_tables::{Eye, Tables};

use crate::format::PixelFormat;
use crate::frame::Frame;
use crate::stitcher::{StitchError, check_source};

/// From this raw value on a pixel counts as clipped.
const CLIPPED: u8 = 250;
/// Bin of what is clipped.
const CLIPPED_BIN: u8 = 255;
/// Values that quantiles are compared at: above the noise of black, below clipping.
const TRUSTED: core::ops::RangeInclusive<u16> = 16..=250;
/// Quantiles are the multiples of one sixteenth, without 0 and 1.
const PARTS: u32 = 16;
const QUANTILES: usize = PARTS as usize - 1;
/// Fewer pairs or quantiles to compare than these say nothing.
const FEWEST_PAIRS: u32 = 32;
const FEWEST_QUANTILES: usize = 4;

const ONE_Q24: i32 = 1 << 24;
/// One stop either way.
const RATIO_Q24: [i32; 2] = [ONE_Q24 / 2, 2 * ONE_Q24];

/// Histograms of both eyes at a table's metering pairs: luma, or green. 1 KB.
#[derive(Debug, Clone)]
pub struct Meter {
    counts: [[u16; 256]; 2],
}

impl Default for Meter {
    fn default() -> Self {
        Self::new()
    }
}

impl Meter {
    /// Nothing read yet.
    pub const fn new() -> Self {
        Self {
            counts: [[0; 256]; 2],
        }
    }

    /// Reads an eye's new frame; what was read of that eye before is forgotten. The table's curve
    /// counts, gains in use do not. A table without metering pairs leaves nothing to read.
    ///
    /// # Errors
    /// [`StitchError::SourceSize`] if the frame is not one that the table was made for.
    pub fn read<F: PixelFormat>(
        &mut self,
        tables: &Tables<'_>,
        eye: Eye,
        frame: &Frame<'_, F>,
    ) -> Result<(), StitchError> {
        check_source(frame, tables, eye)?;
        let [left, right] = &mut self.counts;
        let counts = match eye {
            Eye::Left => left,
            Eye::Right => right,
        };
        counts.fill(0);
        let curve = tables.curve(eye, F::METERED);
        for pair in tables.meter_pairs() {
            let Some(value) = frame.pixel(pair.pixel(eye)).and_then(F::metered) else {
                continue;
            };
            let bin = match curve {
                _ if value >= CLIPPED => CLIPPED_BIN,
                Some(curve) => curve[usize::from(value)],
                None => value,
            };
            counts[usize::from(bin)] += 1;
        }
        Ok(())
    }

    /// How many times brighter the left eye is, Q12; `None` if there is too little to compare.
    ///
    /// Both eyes' quantiles are compared, not their pixels: where something near is seen twice or
    /// by one eye alone, a few pairs differ and the quantiles hardly move. The median of all
    /// quantiles that no eye clips decides.
    fn ratio_q12(&self) -> Option<u32> {
        let [left, right] = self.counts.each_ref().map(quantiles_q8);
        let (left, right) = (left?, right?);
        let mut ratios = [0; QUANTILES];
        let mut count = 0;
        let both = left.into_iter().zip(right);
        let trusted = |q8: u32| TRUSTED.contains(&(((q8 + 128) >> 8) as u16));
        for (left, right) in both.filter(|(left, right)| trusted(*left) && trusted(*right)) {
            if let Some(slot) = ratios.get_mut(count) {
                *slot = (left << 12) / right.max(1);
                count += 1;
            }
        }
        let ratios = ratios.get(..count)?;
        if count < FEWEST_QUANTILES {
            return None;
        }
        let median = ratios.iter().find(|&&ratio| {
            let below = ratios.iter().filter(|other| **other < ratio).count();
            let up_to = ratios.iter().filter(|other| **other <= ratio).count();
            below <= count / 2 && count / 2 < up_to
        });
        median.copied()
    }
}

/// Values in Q8 that k sixteenths of what was counted lie below; each count is spread evenly over
/// its level.
fn quantiles_q8(counts: &[u16; 256]) -> Option<[u32; QUANTILES]> {
    let total: u32 = counts.iter().map(|n| u32::from(*n)).sum();
    if total < FEWEST_PAIRS {
        return None;
    }
    let mut quantiles = [0; QUANTILES];
    let mut wanted = (1..).map(|k| k * total).zip(&mut quantiles).peekable();
    let mut below = 0;
    for (level, count) in (0u32..).zip(counts) {
        let here = PARTS * u32::from(*count);
        while let Some((rank, quantile)) = wanted.next_if(|(rank, _)| *rank <= below + here) {
            let into_q8 = ((rank - below) << 8) / here.max(1);
            *quantile = ((level << 8) + into_q8).saturating_sub(128);
        }
        below += here;
    }
    Some(quantiles)
}

/// How much brighter the left eye is than the right, followed slowly. 8 bytes, the caller's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Exposure {
    ratio_q24: i32,
    rate_log2: u8,
}

impl Exposure {
    /// Rate with a half-life of 11 updates.
    pub const USUAL_RATE: u8 = 4;

    /// Equal eyes. Each update closes 1/2^`rate_log2` of the gap: a half-life of 0.7 times
    /// 2^`rate_log2` updates. Rates over 10 count as 10.
    pub const fn new(rate_log2: u8) -> Self {
        Self {
            ratio_q24: ONE_Q24,
            rate_log2: if rate_log2 > 10 { 10 } else { rate_log2 },
        }
    }

    /// Moves towards what was read, never past it and never further than one stop from equal.
    /// `false`, and nothing moves, if there was too little to compare.
    pub fn update(&mut self, meter: &Meter) -> bool {
        let Some(ratio_q12) = meter.ratio_q12() else {
            return false;
        };
        let [low, high] = RATIO_Q24;
        let read_q24 = (ratio_q12.min(1 << 18) << 12) as i32;
        let gap = read_q24.clamp(low, high) - self.ratio_q24;
        self.ratio_q24 += gap >> self.rate_log2;
        true
    }

    /// How many times brighter the left eye is, Q24: 1/2 to 2.
    pub const fn ratio_q24(&self) -> i32 {
        self.ratio_q24
    }

    /// Gains that make both eyes equal, half the way each.
    pub const fn gains(&self) -> Gains {
        let right = (self.ratio_q24 as u32).isqrt();
        // Never 0, but the compiler cannot know.
        let divisor = if right == 0 { 1 } else { right };
        Gains {
            q12: [(ONE_Q24 as u32 + divisor / 2) / divisor, right],
        }
    }
}

/// A gain for each eye, from 0.7 to 1.42.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gains {
    q12: [u32; 2],
}

impl Gains {
    /// Both eyes as they are.
    pub const ONE: Gains = Gains { q12: [1 << 12; 2] };

    /// Gain of an eye, Q12.
    pub const fn q12(&self, eye: Eye) -> u32 {
        let [left, right] = self.q12;
        match eye {
            Eye::Left => left,
            Eye::Right => right,
        }
    }
}
