//! Curves for every format from a rig's curves for red, green and blue.
//!
//! Luma and chroma are BT.601, full range (ITU-T T.871). A curve sees one channel, so Gray8 and Yuyv
//! cannot follow three curves of RGB exactly:
//!
//! - luma becomes what it becomes for greys, which is the mean of the three curves by their share
//!   in luma: exact for greys;
//! - U and V become the line through what colours near grey become, by least squares: its offset
//!   is a colour cast, its slope contrast. A cast that changes with brightness is lost.
//!
//! [`ToneError`] says what that costs over the same colours.

use serde::Serialize;
use tectum_optics::RgbCurves;
use tectum_tables::builder::ToneData;
use tectum_tables::{Channel, Curve};

/// Brightest grey of the colours that chroma is fitted to, and the step between greys.
const GREYS: [u32; 2] = [240, 16];
/// Furthest that U and V of these colours are from grey, and the step: where underwater and
/// indoor scenes have nearly all their colours.
const CHROMA: [i32; 2] = [32, 8];

/// By how much the curves for luma and chroma miss those for red, green and blue, over colours near
/// grey: root mean square, levels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToneError {
    /// Y.
    pub luma_rms: f64,
    /// U and V.
    pub chroma_rms: f64,
}

/// A colour as luma and offsets of chroma from grey.
type Yuv = [f64; 3];

/// Curves of both eyes for all channels; those that change nothing are left out.
pub fn tone(eyes: &[RgbCurves; 2]) -> ([ToneData; 2], ToneError) {
    let fitted = eyes.each_ref().map(curves);
    let mean = |of: fn(&ToneError) -> f64| {
        let squares = fitted.iter().map(|(_, error)| of(error) * of(error));
        (squares.sum::<f64>() / 2.0).sqrt()
    };
    let error = ToneError {
        luma_rms: mean(|e| e.luma_rms),
        chroma_rms: mean(|e| e.chroma_rms),
    };
    (fitted.map(|(data, _)| data), error)
}

fn curves(rgb: &RgbCurves) -> (ToneData, ToneError) {
    let luma: Curve = std::array::from_fn(|v| {
        let [r, g, b] = rgb.map(|curve| f64::from(curve[v]));
        level(0.299 * r + 0.587 * g + 0.114 * b)
    });
    let pairs: Vec<[Yuv; 2]> = colours()
        .filter_map(|yuv| Some([yuv, toned(rgb, yuv)?]))
        .collect();
    let [u, v] = [1, 2].map(|i| Line::through(pairs.iter().map(|[from, to]| [from[i], to[i]])));
    let rms = |squares: f64, count: usize| (squares / count.max(1) as f64).sqrt();
    let luma_squares = pairs.iter().map(|[from, to]| {
        let miss = interpolated(&luma, from[0]) - to[0];
        miss * miss
    });
    let error = ToneError {
        luma_rms: rms(luma_squares.sum(), pairs.len()),
        chroma_rms: rms(u.squares + v.squares, 2 * pairs.len()),
    };
    let mut data = ToneData::default();
    let [red, green, blue] = *rgb;
    for (channel, curve) in [
        (Channel::Luma, luma),
        (Channel::U, u.curve()),
        (Channel::V, v.curve()),
        (Channel::Red, red),
        (Channel::Green, green),
        (Channel::Blue, blue),
    ] {
        let changes = (0..=255).zip(curve).any(|(value, to)| value != to);
        data[channel as usize] = changes.then_some(curve);
    }
    (data, error)
}

/// Colours near grey.
fn colours() -> impl Iterator<Item = Yuv> {
    let [brightest, step] = GREYS;
    let [widest, between] = CHROMA;
    let chroma = move || (-widest..=widest).step_by(between as usize);
    (step..=brightest)
        .step_by(step as usize)
        .flat_map(move |y| chroma().flat_map(move |u| chroma().map(move |v| [y as i32, u, v])))
        .map(|yuv| yuv.map(f64::from))
}

/// What the curves make of a colour; `None` if it has no red, green and blue of 0 to 255.
fn toned(rgb: &RgbCurves, [y, u, v]: Yuv) -> Option<Yuv> {
    let colour = [
        y + 1.402 * v,
        y - (0.114 * 1.772 * u + 0.299 * 1.402 * v) / 0.587,
        y + 1.772 * u,
    ];
    if colour.iter().any(|value| !(0.0..=255.0).contains(value)) {
        return None;
    }
    let [r, g, b] = [0, 1, 2].map(|i| interpolated(&rgb[i], colour[i]));
    let y = 0.299 * r + 0.587 * g + 0.114 * b;
    Some([y, (b - y) / 1.772, (r - y) / 1.402])
}

/// A curve between its values.
pub(crate) fn interpolated(curve: &Curve, value: f64) -> f64 {
    let below = (value as usize).min(254);
    let [low, high] = [curve[below], curve[below + 1]].map(f64::from);
    low + (high - low) * (value - below as f64)
}

fn level(value: f64) -> u8 {
    (value + 0.5).floor().clamp(0.0, 255.0) as u8
}

/// A straight line and how far its points are off it, squared and added up.
struct Line {
    offset: f64,
    slope: f64,
    squares: f64,
}

impl Line {
    /// Least squares through points `[x, y]`.
    fn through(points: impl Iterator<Item = [f64; 2]> + Clone) -> Self {
        let count = points.clone().count().max(1) as f64;
        let mean = |i: usize| points.clone().map(|p| p[i]).sum::<f64>() / count;
        let [mean_x, mean_y] = [mean(0), mean(1)];
        let product = |i: usize, j: usize| {
            let off = |p: [f64; 2]| [p[0] - mean_x, p[1] - mean_y];
            points.clone().map(off).map(|p| p[i] * p[j]).sum::<f64>()
        };
        let slope = product(0, 1) / product(0, 0);
        Self {
            offset: mean_y - slope * mean_x,
            slope,
            squares: (product(1, 1) - slope * product(0, 1)).max(0.0),
        }
    }

    fn curve(&self) -> Curve {
        std::array::from_fn(|value| {
            level(128.0 + self.offset + self.slope * (value as f64 - 128.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scaled(gains: [f64; 3]) -> RgbCurves {
        gains.map(|gain| std::array::from_fn(|v| level(gain * v as f64)))
    }

    #[test]
    fn what_changes_nothing_is_left_out() {
        let same = scaled([1.0; 3]);
        let (tone, error) = tone(&[same, scaled([0.9; 3])]);
        assert_eq!(tone[0], ToneData::default());
        assert!(tone[1].iter().all(Option::is_some));
        // Curves are rounded: half a level at most.
        assert!(error.luma_rms < 0.5 && error.chroma_rms < 0.5, "{error:?}");
    }

    #[test]
    fn a_darker_exposure_scales_luma_and_chroma() {
        let (data, _) = curves(&scaled([0.8; 3]));
        let [luma, u, v] = [0, 1, 2].map(|i| data[i].unwrap());
        assert_eq!(luma[200], 160);
        for chroma in [u, v] {
            assert_eq!([chroma[128], chroma[178], chroma[78]], [128, 168, 88]);
        }
    }

    #[test]
    fn a_colour_cast_moves_chroma() {
        // Blue taken off, red added: U falls, V rises.
        let (data, error) = curves(&scaled([1.1, 1.0, 0.8]));
        let [u, v] = [1, 2].map(|i| data[i].unwrap());
        assert!(u[128] < 123 && v[128] > 130, "{} {}", u[128], v[128]);
        // Greys of 16 to 240 have casts of 16 to 240 times 0.118; the line has one for all.
        println!("{error:?}");
        assert!(error.chroma_rms < 8.0, "{error:?}");
    }

    #[test]
    fn luma_of_greys_is_exact() {
        let rgb = scaled([1.1, 0.95, 0.8]);
        let (data, _) = curves(&rgb);
        let luma = data[0].unwrap();
        for v in 0..256 {
            let [r, g, b] = rgb.map(|curve| f64::from(curve[v]));
            let exact = 0.299 * r + 0.587 * g + 0.114 * b;
            assert!((f64::from(luma[v]) - exact).abs() <= 0.5);
        }
    }
}
