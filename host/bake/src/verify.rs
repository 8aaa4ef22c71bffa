//! Proof that a table and the core do what they claim, with numbers.

use rayon::prelude::*;
use serde::Serialize;
use tectum_core::{Channel, Eye, Sampler, Tables};
use tectum_optics::{OutputMap, Rig};
use tectum_tables::RunKind;

use crate::bake::ErrorSummary;
use crate::convert::from_rgb8;
use crate::output_map::output_map;
use crate::reference::{overlay, position_q8, quantised};
use crate::{Format, Pair, Pass, StitchFailure, draw_overlay, stitch};

/// What was compared and what came out.
#[derive(Debug, Clone, Serialize)]
pub struct Verification {
    /// Output pixels of the table.
    pub pixels: usize,
    /// Bytes compared between the core and the quantised reference, over all formats, samplers
    /// and ways to run.
    pub bytes_compared: usize,
    /// Bytes that differ: must be 0.
    pub mismatches: usize,
    /// The same, by format.
    pub formats: Vec<FormatResult>,
    /// Greatest difference of the core from unrounded f64 interpolation at the table's own
    /// positions, single-eye pixels, least significant bits before tone: at most 1/2.
    pub rounding_error_lsb: f64,
    /// Distance of the table's source positions from the rig's camera models.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coordinate_error_px: Option<ErrorSummary>,
    /// Difference of the core from unrounded f64 interpolation at the models' positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_error_lsb: Option<PixelError>,
}

/// Result of one pixel format.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct FormatResult {
    /// Format.
    pub format: Format,
    /// Bytes compared.
    pub bytes_compared: usize,
    /// Bytes that differ.
    pub mismatches: usize,
}

/// Difference of luma values, least significant bits of the source: of a pixel that went through a
/// tone curve, the difference from the nearest value that the curve makes that pixel of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelError {
    /// Greatest.
    pub max: f64,
    /// Mean.
    pub mean: f64,
}

/// Why nothing was verified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The rig is not the one that the table was baked from.
    #[error("the table was baked from another rig (or another version of it): bake it again")]
    OtherRig,
    /// A picture is not what the table needs.
    #[error(transparent)]
    Stitch(#[from] StitchFailure),
}

/// Compares the core with both references on a pair of pictures (8-bit RGB, tightly packed).
///
/// # Errors
/// [`VerifyError`] if rig, table and pictures do not belong together.
pub fn verify(
    tables: &Tables<'_>,
    rig: Option<&Rig>,
    rgb: Pair<'_>,
) -> Result<Verification, VerifyError> {
    if rig.is_some_and(|rig| rig.fingerprint() != tables.rig_fingerprint()) {
        return Err(VerifyError::OtherRig);
    }
    let formats: Vec<FormatResult> = Format::ALL
        .into_par_iter()
        .filter(|format| fits(tables, *format))
        .map(|format| compare(tables, format, rgb))
        .collect::<Result<_, _>>()?;
    let [left, right] = [rgb.left, rgb.right].map(|rgb| from_rgb8(Format::Gray8, 1, rgb));
    let luma = Pair {
        left: &left,
        right: &right,
    };
    let core = stitch(tables, Format::Gray8, Sampler::Bilinear, Pass::Both, luma)?;
    let at_table =
        |eye, x, y| position_q8(tables, eye, x, y).map(|p| p.map(|q8| f64::from(q8) / 256.0));
    let rounding = differences(tables, luma, &core, at_table);
    let model = rig.map(|rig| ModelPositions {
        map: output_map(tables),
        rig,
    });
    Ok(Verification {
        pixels: usize::from(tables.output_width_px()) * usize::from(tables.output_height_px()),
        bytes_compared: formats.iter().map(|f| f.bytes_compared).sum(),
        mismatches: formats.iter().map(|f| f.mismatches).sum(),
        formats,
        rounding_error_lsb: rounding.max,
        coordinate_error_px: model.as_ref().map(|model| coordinate_error(tables, model)),
        pixel_error_lsb: model
            .as_ref()
            .map(|model| differences(tables, luma, &core, |e, x, y| model.at(e, x, y))),
    })
}

fn fits(tables: &Tables<'_>, format: Format) -> bool {
    let sources = Eye::BOTH
        .into_iter()
        .filter_map(|eye| tables.source_size_px(eye));
    format.holds_width(tables.output_width_px())
        && sources
            .into_iter()
            .all(|[width, _]| format.holds_width(width))
}

fn compare(
    tables: &Tables<'_>,
    format: Format,
    rgb: Pair<'_>,
) -> Result<FormatResult, StitchFailure> {
    let picture = |eye, rgb| {
        let [width, _] = tables.source_size_px(eye).unwrap_or_default();
        from_rgb8(format, width.into(), rgb)
    };
    let left = picture(Eye::Left, rgb.left);
    let right = picture(Eye::Right, rgb.right);
    let pair = Pair {
        left: &left,
        right: &right,
    };
    let mut result = FormatResult {
        format,
        bytes_compared: 0,
        mismatches: 0,
    };
    for sampler in [Sampler::Nearest, Sampler::Bilinear] {
        let mut expected = None;
        for pass in [Pass::Both, Pass::OneEyeAtATime] {
            // The core first: it refuses pictures of a wrong size, the reference does not.
            let core = stitch(tables, format, sampler, pass, pair)?;
            let expected =
                expected.get_or_insert_with(|| quantised::stitch(tables, format, sampler, pair));
            result.bytes_compared += core.len();
            result.mismatches += differing(&core, expected);
        }
        // The same picture with the table's scales, if it has any.
        if let (Some(overlay), Some(plain)) = (tables.overlay(), expected) {
            let expected = overlay::draw(&overlay, format, &plain);
            let mut core = plain;
            draw_overlay(&overlay, format, &mut core)?;
            result.bytes_compared += core.len();
            result.mismatches += differing(&core, &expected);
        }
    }
    Ok(result)
}

fn differing(a: &[u8], b: &[u8]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Source positions straight from the rig.
struct ModelPositions<'a> {
    map: OutputMap,
    rig: &'a Rig,
}

impl ModelPositions<'_> {
    fn at(&self, eye: Eye, x: usize, y: usize) -> Option<[f64; 2]> {
        let (index, rig_eye) = match eye {
            Eye::Left => (0, self.rig.left.as_ref()?),
            Eye::Right => (1, self.rig.right.as_ref()?),
        };
        let direction = self.map.ray(x as f64, y as f64)?;
        let ray = self.rig.shown_ray(index, &direction)?;
        rig_eye.eye.project(&ray).ok()
    }
}

/// Greatest, sum, sum of squares and number of what `f(eye, x, y)` gives for the shown pixels of every
/// eye. Rows are summed up from the top: the same on every machine.
fn over_shown(
    tables: &Tables<'_>,
    single_only: bool,
    f: impl Fn(Eye, usize, usize) -> Option<f64> + Sync,
) -> Sums {
    let rows: Vec<Sums> = (0..tables.output_height_px())
        .into_par_iter()
        .map(|y| {
            let mut sums = Sums::default();
            for run in tables.runs(y) {
                let eyes: &[Eye] = match run.kind {
                    RunKind::Void => &[],
                    RunKind::Left => &[Eye::Left],
                    RunKind::Right => &[Eye::Right],
                    RunKind::Blend(_) if single_only => &[],
                    RunKind::Blend(_) => &Eye::BOTH,
                };
                for eye in eyes {
                    let columns = run.start as usize..(run.start + run.len) as usize;
                    for value in columns.filter_map(|x| f(*eye, x, usize::from(y))) {
                        sums = sums.with(Sums {
                            max: value,
                            sum: value,
                            squares: value * value,
                            count: 1,
                        });
                    }
                }
            }
            sums
        })
        .collect();
    rows.into_iter().fold(Sums::default(), Sums::with)
}

/// Of values that are not negative.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    max: f64,
    sum: f64,
    squares: f64,
    count: usize,
}

impl Sums {
    fn with(self, other: Self) -> Self {
        Self {
            max: self.max.max(other.max),
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            count: self.count + other.count,
        }
    }
}

fn coordinate_error(tables: &Tables<'_>, model: &ModelPositions<'_>) -> ErrorSummary {
    let errors = over_shown(tables, false, |eye, x, y| {
        let [tx, ty] = position_q8(tables, eye, x, y)?.map(|q8| f64::from(q8) / 256.0);
        let [mx, my] = model.at(eye, x, y)?;
        Some((tx - mx).hypot(ty - my))
    });
    ErrorSummary {
        max: errors.max,
        rms: (errors.squares / errors.count.max(1) as f64).sqrt(),
    }
}

/// Difference of the core's luma from unrounded interpolation at given positions, on pixels that
/// one eye shows alone.
fn differences(
    tables: &Tables<'_>,
    luma: Pair<'_>,
    core: &[u8],
    position: impl Fn(Eye, usize, usize) -> Option<[f64; 2]> + Sync,
) -> PixelError {
    let width = usize::from(tables.output_width_px());
    let errors = over_shown(tables, true, |eye, x, y| {
        let frame = match eye {
            Eye::Left => luma.left,
            Eye::Right => luma.right,
        };
        let size = tables.source_size_px(eye)?;
        let exact = interpolate(frame, size, position(eye, x, y)?)?;
        Some(distance(tables, eye, core[y * width + x], exact))
    });
    PixelError {
        max: errors.max,
        mean: errors.sum / errors.count.max(1) as f64,
    }
}

/// How far the nearest luma value that the core may have made `pixel` of is from `exact`; 256 if the
/// tone curve makes it of none.
fn distance(tables: &Tables<'_>, eye: Eye, pixel: u8, exact: f64) -> f64 {
    let Some(curve) = tables.curve(eye, Channel::Luma) else {
        return (f64::from(pixel) - exact).abs();
    };
    let sources = (0..=255u8).zip(curve).filter(|(_, toned)| **toned == pixel);
    sources.fold(256.0, |nearest, (source, _)| {
        (f64::from(source) - exact).abs().min(nearest)
    })
}

/// Bilinear value of a luma frame at a position; `None` where its box is not inside.
fn interpolate(frame: &[u8], [width, height]: [u16; 2], [x, y]: [f64; 2]) -> Option<f64> {
    let (width, height) = (usize::from(width), usize::from(height));
    let inside = x >= 0.0 && y >= 0.0 && x < (width - 1) as f64 && y < (height - 1) as f64;
    if !inside {
        return None;
    }
    let (left, top) = (x as usize, y as usize);
    let (fx, fy) = (x - left as f64, y - top as f64);
    let at = |x: usize, y: usize| f64::from(frame[y * width + x]);
    let upper = (1.0 - fx) * at(left, top) + fx * at(left + 1, top);
    let lower = (1.0 - fx) * at(left, top + 1) + fx * at(left + 1, top + 1);
    Some((1.0 - fy) * upper + fy * lower)
}
