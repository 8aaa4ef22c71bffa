//! Curves that a stitcher sends sampled values through.

use core::marker::PhantomData;

use tectum_tables::{Channel, Curve, Eye, Tables};

use crate::exposure::Gains;
use crate::format::PixelFormat;

/// Curves of one eye for the channels of a format, in the order of [`PixelFormat::CHANNELS`]; the
/// rest is not used. All are there, so that a loop has nothing to decide.
pub(crate) type Curves<'t> = [&'t Curve; MAX_CHANNELS];

/// For channels without a curve beside others that have one.
static IDENTITY: Curve = {
    let mut curve = [0; 256];
    let mut value = 0;
    while value < curve.len() {
        curve[value] = value as u8;
        value += 1;
    }
    curve
};

/// Channels of the richest format.
const MAX_CHANNELS: usize = 3;
/// Binary point of gains.
const ONE_Q12: u32 = 1 << 12;
/// From this value on, of what is brightened after and of what is darkened before, a gain's curve
/// runs straight to white.
const KNEE: u32 = 224;
const WHITE: u32 = 255;

/// Curves in the caller's memory for pixel format `F`: those of a table, times a gain for each
/// eye. 1.5 KB; [`crate::Stitcher::with_tone`] stitches with them.
#[derive(Debug, Clone)]
pub struct Tone<F> {
    curves: [[Curve; MAX_CHANNELS]; 2],
    format: PhantomData<F>,
}

impl<F: PixelFormat> Tone<F> {
    /// The curves of `tables` times `gains`.
    pub fn new(tables: &Tables<'_>, gains: Gains) -> Self {
        let mut tone = Self {
            curves: [[[0; 256]; MAX_CHANNELS]; 2],
            format: PhantomData,
        };
        tone.set(tables, gains);
        tone
    }

    /// Replaces all curves by those of `tables` times `gains`. Some 15 instructions for each of
    /// 512 to 1536 entries.
    pub fn set(&mut self, tables: &Tables<'_>, gains: Gains) {
        for (eye, curves) in Eye::BOTH.into_iter().zip(&mut self.curves) {
            let gain_q12 = gains.q12(eye);
            for (&channel, curve) in F::CHANNELS.iter().zip(curves) {
                let table = tables.curve(eye, channel);
                for (value, out) in (0..=255).zip(curve) {
                    let value = table.map_or(value, |table| table[usize::from(value)]);
                    *out = gained(channel, value, gain_q12);
                }
            }
        }
    }

    pub(crate) fn curves(&self, eye: Eye) -> Curves<'_> {
        let [left, right] = &self.curves;
        match eye {
            Eye::Left => left,
            Eye::Right => right,
        }
        .each_ref()
    }
}

/// The table's curves of an eye for the channels of a format; `None` if it has none of them.
pub(crate) fn of_table<'t, F: PixelFormat>(tables: &Tables<'t>, eye: Eye) -> Option<Curves<'t>> {
    let mut curves: Curves<'t> = [&IDENTITY; MAX_CHANNELS];
    let mut any = false;
    for (&channel, slot) in F::CHANNELS.iter().zip(&mut curves) {
        if let Some(curve) = tables.curve(eye, channel) {
            (*slot, any) = (curve, true);
        }
    }
    any.then_some(curves)
}

/// What `value` becomes at a gain of 0.5 to 2: `FORMAT.md`, "Gain".
fn gained(channel: Channel, value: u8, gain_q12: u32) -> u8 {
    match channel {
        Channel::U | Channel::V => gained_chroma(value, gain_q12),
        Channel::Luma | Channel::Red | Channel::Green | Channel::Blue => {
            gained_light(u32::from(value), gain_q12)
        }
    }
}

/// Times the gain up to the knee, then straight to white, which stays white: nothing below it is
/// clipped, and a gain and its inverse undo each other.
fn gained_light(value: u32, gain_q12: u32) -> u8 {
    let knee_q12 = KNEE * ONE_Q12;
    let gained_q12 = gain_q12 * value;
    let rounded = |q12: u32| (q12 + ONE_Q12 / 2) >> 12;
    let gained = if gain_q12 >= ONE_Q12 {
        match gained_q12.checked_sub(knee_q12) {
            Some(over_q12) if over_q12 > 0 => {
                let reach_q12 = gain_q12 * WHITE - knee_q12;
                KNEE + ((WHITE - KNEE) * over_q12 + reach_q12 / 2) / reach_q12.max(1)
            }
            _ => rounded(gained_q12),
        }
    } else {
        match value.checked_sub(KNEE) {
            Some(over) => {
                let knee_q12 = gain_q12 * KNEE;
                rounded(knee_q12 + (WHITE * ONE_Q12 - knee_q12) * over / (WHITE - KNEE))
            }
            None => rounded(gained_q12),
        }
    };
    gained as u8
}

/// Times the gain about grey, which is 128.
fn gained_chroma(value: u8, gain_q12: u32) -> u8 {
    let from_grey_q12 = (i32::from(value) - 128) * gain_q12 as i32;
    let gained = 128 + ((from_grey_q12 + ONE_Q12 as i32 / 2) >> 12);
    gained.clamp(0, 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GAINS: core::ops::Range<u32> = ONE_Q12 / 2..2 * ONE_Q12;

    #[test]
    fn a_gain_of_one_changes_nothing() {
        for value in 0..=255 {
            for channel in Channel::ALL {
                assert_eq!(gained(channel, value, ONE_Q12), value);
            }
        }
    }

    proptest! {
        #[test]
        fn curves_rise_from_black_to_white(gain in GAINS) {
            let curve = |value| gained_light(value, gain);
            prop_assert_eq!([curve(0), curve(255)], [0, 255]);
            for value in 1..=255 {
                prop_assert!(curve(value - 1) <= curve(value));
            }
            for value in 1..=255u8 {
                prop_assert!(gained_chroma(value - 1, gain) <= gained_chroma(value, gain));
            }
            prop_assert_eq!(gained_chroma(128, gain), 128);
        }

        #[test]
        fn light_is_the_polyline_rounded(gain in GAINS, value in 0u32..256) {
            // (0, 0), the knee, (255, 255), in f64.
            let g = f64::from(gain) / 4096.0;
            let (x, y) = (224.0 / g.max(1.0), 224.0 * g.min(1.0));
            let v = f64::from(value);
            let exact = if v <= x { g * v } else { y + (v - x) * (255.0 - y) / (255.0 - x) };
            // Half a level of rounding; the division before it loses 1/4096 at most.
            let error = (f64::from(gained_light(value, gain)) - exact).abs();
            prop_assert!(error <= 0.5 + 1.0 / 4096.0 + 1e-9, "{error}");
        }

        #[test]
        fn only_white_is_sent_to_white_by_darkening(gain in GAINS.start..ONE_Q12) {
            prop_assert!(gained_light(254, gain) < 255);
        }

        #[test]
        fn a_gain_and_its_inverse_undo_each_other(gain in ONE_Q12..2 * ONE_Q12) {
            let inverse = (1 << 24) / gain;
            for value in 0..=255 {
                let back = gained_light(u32::from(gained_light(value, gain)), inverse);
                // Where the curve is flat, a level stands for as many as the slope says.
                let slope = f64::from(gain) * 255.0 / 4096.0 - 224.0;
                let tolerance = (slope / 31.0).max(1.0) * 0.5 + 1.0;
                let error = (f64::from(back) - f64::from(value)).abs();
                prop_assert!(error <= tolerance, "{value} came back as {back}");
            }
        }
    }
}
