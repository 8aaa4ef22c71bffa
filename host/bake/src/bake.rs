//! Rig to table.

use rayon::prelude::*;
use serde::Serialize;
use tectum_optics::convention::angle_between;
use tectum_optics::{OutputMap, Rig, RowRays};
use tectum_tables::builder::{RunData, RunsTooLong, TableBuilder};
use tectum_tables::{TableError, Tables};

use crate::mesh::{FittedMesh, KEPT_BYTES, Targets, fit};
use crate::metering::meter_pairs;
use crate::output_map::{from_table, to_table};
use crate::rays::eye_rays;
use crate::rows::{RunRule, for_each_row, shown_eyes};
use crate::scales::ScalesReport;
use crate::sights::{Seam, Sights, is_hidden};
use crate::sufficient::{Sufficient, sufficient};
use crate::tone::{ToneError, tone};

/// Steps to try, coarsest first, as powers of two.
pub(crate) const STEPS_LOG2: [u32; 3] = [5, 4, 3];

/// What to bake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakeOptions {
    /// The stitched picture.
    pub output: OutputMap,
    /// Greatest distance of a source position from the camera model's, px.
    pub max_error_px: f64,
    /// Width of the transition between the eyes, rad.
    pub feather_rad: f64,
}

/// A finished table and what it costs.
#[derive(Debug, Clone)]
pub struct Baked {
    /// The table.
    pub bytes: Vec<u8>,
    /// Its cost sheet.
    pub report: Report,
}

/// The cost sheet of a table.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Where the bytes are.
    pub bytes: Bytes,
    /// Mesh step of left and right eye, output px.
    pub step: [Option<u32>; 2],
    /// Distance of the table's source positions from the camera models'.
    pub coordinate_error_px: ErrorSummary,
    /// Angle between the direction that a pixel stands for and the one that its eye shows there, at
    /// the stitch distance, degrees: what the rig's local bend costs a look-up in the stitched
    /// picture. `None` without a bend.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bend_deg: Option<ErrorSummary>,
    /// What luma and chroma curves lose against the rig's curves, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tone_error: Option<ToneError>,
    /// Scales, if the table has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scales: Option<ScalesReport>,
    /// Share of output pixels by owner.
    pub pixels: Owners,
    /// Bytes of a source frame in 8-bit luma, left and right.
    pub source_bytes_gray8: [usize; 2],
}

/// Bytes of a table by section.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Bytes {
    /// Whole file.
    pub total: usize,
    /// Left mesh.
    pub mesh_left: usize,
    /// Right mesh.
    pub mesh_right: usize,
    /// Runs.
    pub runs: usize,
    /// Tone curves.
    pub tone: usize,
    /// Metering pairs.
    pub meter: usize,
    /// Lines and labels.
    pub overlay: usize,
    /// Header, directory, directions and metadata.
    pub other: usize,
}

/// Greatest and root-mean-square error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// Greatest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

/// Number of output pixels by owner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Owners {
    /// Neither eye.
    pub void: usize,
    /// Left eye alone.
    pub left: usize,
    /// Right eye alone.
    pub right: usize,
    /// Both.
    pub blend: usize,
}

/// Least error that may be asked for: half a step of a mesh's finest positions.
const MIN_ERROR_PX: f64 = 0.004;
/// Greatest error that may be asked for.
pub(crate) const MAX_ERROR_PX: f64 = 10.0;

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The option itself makes no sense.
    #[error(
        "--max-error {0} px is not allowed: it must be between {MIN_ERROR_PX} and {MAX_ERROR_PX}"
    )]
    MaxError(f64),
    /// The feather makes no sense.
    #[error("--feather of {0} degrees is not allowed: it must be between 0 and 90")]
    Feather(f64),
    /// Larger than a table can be.
    #[error("an output of {0}x{1} px is too large: at most 8192 px a side")]
    Output(u16, u16),
    /// No mesh is good enough.
    #[error(
        "{eye} eye: no mesh meets {wanted_px} px: {reached}. {}",
        advice(*best_px, sufficient.as_ref())
    )]
    Accuracy {
        /// Which eye.
        eye: &'static str,
        /// Error asked for.
        wanted_px: f64,
        /// What each step reached.
        reached: String,
        /// The least error of any step; infinite if no step gives a mesh.
        best_px: f64,
        /// What would give a table, if it was looked for and found.
        sufficient: Option<Sufficient>,
    },
    /// No output pixel shows either eye.
    #[error("no output pixel is seen by an eye: check the projection's axis and the field")]
    Empty,
    /// The view cannot be expressed in the table's fixed point.
    #[error("the projection's numbers do not fit the table")]
    OutputMap,
    /// Too many different rows.
    #[error(transparent)]
    Runs(#[from] RunsTooLong),
    /// The finished table does not pass its own proof: a bug here.
    #[error("the finished table is not valid: {0}. Please report this with the rig file")]
    Proof(TableError),
}

/// What to do where no mesh is good enough.
fn advice(best_px: f64, sufficient: Option<&Sufficient>) -> String {
    let enough = sufficient.map_or_else(String::new, |enough| format!(" ({enough} suffices)"));
    if best_px <= MAX_ERROR_PX {
        format!(
            "Allow more with --max-error{enough}, or ask for a larger output (finer pixels bend less \
             from vertex to vertex)"
        )
    } else {
        format!(
            "Ask for a larger output{enough}: its vertices lie closer together in the eye's picture. \
             No --max-error helps"
        )
    }
}

/// Bakes a table. A rig with `[stitching]` gives its seam, warp and tone, and metering pairs where
/// both eyes are shown.
///
/// Pixels are traced in rows that share memory, and again where their positions are not kept, so that
/// memory grows with the table and a row rather than with the picture: [`memory_bytes`](crate::memory_bytes).
///
/// # Errors
/// [`BakeError`]: an option out of range, or no table that meets it. Up to 2048x1024 px, a few more bakes
/// then find an error or a size that suffices.
pub fn bake(rig: &Rig, options: &BakeOptions) -> Result<Baked, BakeError> {
    let mut result = bake_as_asked(rig, options);
    if let Err(BakeError::Accuracy {
        best_px,
        sufficient: found,
        ..
    }) = &mut result
    {
        *found = sufficient(rig, options, *best_px);
    }
    result
}

/// [`bake`], without looking for what would suffice.
pub(crate) fn bake_as_asked(rig: &Rig, options: &BakeOptions) -> Result<Baked, BakeError> {
    check(options)?;
    // Traced through the table's own numbers, so that rounding them costs no accuracy.
    let output_map = to_table(&options.output).ok_or(BakeError::OutputMap)?;
    let output = from_table(&output_map, options.output.size_px);
    let options = &BakeOptions { output, ..*options };
    let seam = Seam::of(rig, options.feather_rad);
    let sights = Sights::new(rig, &output, seam, margin_px(options));
    let (rows, targets) = trace(&sights, RunRule::of(seam));
    let [left, right] = meshes(rig, &targets, options)?;
    drop(targets);
    if left.is_none() && right.is_none() {
        return Err(BakeError::Empty);
    }
    let coordinate_error_px = total_error(&[&left, &right]);
    let stitching = rig.stitching.as_ref();
    let (tone, tone_error) = stitching
        .and_then(|s| s.tone.as_ref())
        .map(tone)
        .map_or_else(Default::default, |(tone, error)| (tone, Some(error)));
    // Registered eyes are to match; metering takes both.
    let meter_pairs = match (stitching, &left, &right) {
        (Some(_), Some(_), Some(_)) => meter_pairs(rig),
        _ => Vec::new(),
    };
    let rays = |eye: &Option<tectum_optics::RigEye>| {
        eye.as_ref()
            .and_then(|eye| eye_rays(eye, rig.stitch_distance_m))
    };
    let bend_deg = bend_deg(rig, &output, &rows);
    let mut builder = TableBuilder {
        output_size_px: options.output.size_px,
        rig_fingerprint: rig.fingerprint(),
        mesh: [&left, &right].map(|mesh| mesh.as_ref().map(|m| m.data.clone())),
        rows,
        output_map,
        rays: [rays(&rig.left), rays(&rig.right)],
        tone,
        meter_pairs,
        overlay: None,
        metadata: String::new(),
    };
    builder.metadata = metadata(rig, options, coordinate_error_px, bend_deg);
    let bytes = builder.to_bytes()?;
    let tables = Tables::parse(&bytes).map_err(BakeError::Proof)?;
    let report = Report {
        tone_error,
        bend_deg,
        ..report(&tables, &builder, coordinate_error_px)
    };
    Ok(Baked { bytes, report })
}

fn check(options: &BakeOptions) -> Result<(), BakeError> {
    if !(MIN_ERROR_PX..=MAX_ERROR_PX).contains(&options.max_error_px) {
        return Err(BakeError::MaxError(options.max_error_px));
    }
    if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&options.feather_rad) {
        return Err(BakeError::Feather(options.feather_rad.to_degrees()));
    }
    let [width, height] = options.output.size_px;
    if width.max(height) > tectum_tables::MAX_OUTPUT_PX {
        return Err(BakeError::Output(width, height));
    }
    Ok(())
}

/// How far a position must be inside the border of what a bilinear box needs, px: one that is off by
/// the allowed error and its rounding must still have its whole box.
pub(crate) fn margin_px(options: &BakeOptions) -> f64 {
    options.max_error_px + 1.0 / 128.0
}

/// Runs of all rows, and what each eye shows according to them.
pub(crate) fn trace<'a>(
    sights: &'a Sights<'_>,
    rule: RunRule,
) -> (Vec<Vec<RunData>>, [Targets<'a>; 2]) {
    let mut targets = [0, 1].map(|eye| {
        Targets::new(sights.size_px()[0], KEPT_BYTES, move |y, spans| {
            let position = sights.positions(y, eye);
            spans.iter().cloned().flatten().map(position).collect()
        })
    });
    let mut rows = Vec::new();
    let row = |y| sights.row(y);
    for_each_row(sights.size_px(), row, rule, |runs, sights| {
        for (eye, targets) in targets.iter_mut().enumerate() {
            let of_eye = shown_eyes(&runs).filter(|(_, eyes)| eyes.contains(&eye));
            let positions = &sights.positions[eye];
            let shown = of_eye
                .flat_map(|(columns, _)| columns)
                .map(|x| (x, positions[x]));
            targets.push_row(shown.filter(|(_, position)| !is_hidden(position)));
        }
        rows.push(runs);
    });
    (rows, targets)
}

/// The coarsest mesh of each eye that meets the error.
fn meshes(
    rig: &Rig,
    targets: &[Targets<'_>; 2],
    options: &BakeOptions,
) -> Result<[Option<FittedMesh>; 2], BakeError> {
    let eyes = [("left", &rig.left), ("right", &rig.right)];
    let fitted: Vec<_> = (0..2)
        .into_par_iter()
        .map(|i| {
            let (name, Some(eye)) = eyes[i] else {
                return Ok(None);
            };
            coarsest(name, &targets[i], eye.eye.size_px, options.max_error_px)
        })
        .collect();
    let mut fitted = fitted.into_iter();
    let mut next = || fitted.next().unwrap_or(Ok(None));
    Ok([next()?, next()?])
}

fn coarsest(
    eye: &'static str,
    targets: &Targets<'_>,
    source_size_px: [u16; 2],
    wanted_px: f64,
) -> Result<Option<FittedMesh>, BakeError> {
    let mut reached = Vec::new();
    let mut best_px = f64::INFINITY;
    for step_log2 in STEPS_LOG2 {
        let step = 1 << step_log2;
        match fit(targets, source_size_px, step_log2, wanted_px) {
            Ok(Some(mesh)) if mesh.max_error_px > wanted_px => {
                best_px = best_px.min(mesh.max_error_px);
                reached.push(format!("step {step} gives {:.3} px", mesh.max_error_px));
            }
            Ok(mesh) => return Ok(mesh),
            Err(error) => reached.push(format!("step {step}: {error}")),
        }
    }
    Err(BakeError::Accuracy {
        eye,
        wanted_px,
        reached: reached.join(", "),
        best_px,
        sufficient: None,
    })
}

fn total_error(meshes: &[&Option<FittedMesh>]) -> ErrorSummary {
    let meshes = || meshes.iter().copied().flatten();
    let pixels: usize = meshes().map(|m| m.shown_px).sum();
    let squares: f64 = meshes()
        .map(|m| m.rms_error_px * m.rms_error_px * m.shown_px as f64)
        .sum();
    ErrorSummary {
        max: meshes().fold(0.0, |max, m| m.max_error_px.max(max)),
        rms: (squares / pixels.max(1) as f64).sqrt(),
    }
}

/// How far the rig's bend moves what is shown, over all shown pixels and eyes; `None` without one.
fn bend_deg(rig: &Rig, output: &OutputMap, rows: &[Vec<RunData>]) -> Option<ErrorSummary> {
    let warp = rig.stitching.as_ref()?.warp.as_ref()?;
    let rays = RowRays::new(output);
    let of_row = |(y, runs): (usize, &Vec<RunData>)| {
        let (mut max, mut squares, mut count) = (0.0f64, 0.0, 0usize);
        let ray = rays.row(y);
        for (columns, eyes) in shown_eyes(runs) {
            for ray in columns.filter(|_| !eyes.is_empty()).filter_map(&ray) {
                for bent in &warp.bent_of_both(&ray)[eyes.clone()] {
                    let by_deg = angle_between(bent, &ray).to_degrees();
                    max = max.max(by_deg);
                    squares += by_deg * by_deg;
                    count += 1;
                }
            }
        }
        (max, squares, count)
    };
    let rows: Vec<(f64, f64, usize)> = rows.par_iter().enumerate().map(of_row).collect();
    // From the top, so that the sum is the same on every machine.
    let (max, squares, count) = rows.into_iter().fold((0.0f64, 0.0, 0), |a, b| {
        (a.0.max(b.0), a.1 + b.1, a.2 + b.2)
    });
    Some(ErrorSummary {
        max,
        rms: (squares / count.max(1) as f64).sqrt(),
    })
}

fn metadata(
    rig: &Rig,
    options: &BakeOptions,
    error: ErrorSummary,
    bend_deg: Option<ErrorSummary>,
) -> String {
    let bend = bend_deg.map_or_else(String::new, |bend| {
        format!(
            "bend_deg = {{ max = {:.4}, rms = {:.4} }}\n",
            bend.max, bend.rms
        )
    });
    format!(
        "rig = {:?}\nbaked_by = \"tectum {}\"\nstitch_distance_m = {:?}\nfeather_deg = {:.3}\n\
         max_error_px = {}\ncoordinate_error_px = {{ max = {:.4}, rms = {:.4} }}\n{bend}",
        rig.name,
        env!("CARGO_PKG_VERSION"),
        rig.stitch_distance_m,
        options.feather_rad.to_degrees(),
        options.max_error_px,
        error.max,
        error.rms,
    )
}

fn report(tables: &Tables<'_>, builder: &TableBuilder, error: ErrorSummary) -> Report {
    let meshes = [0, 1].map(|i| builder.mesh[i].as_ref());
    let [mesh_left, mesh_right] = meshes.map(|m| m.map_or(0, |m| m.to_bytes().len()));
    let total = tables.length_bytes();
    let runs = tables.runs_bytes();
    let tone = tables.tone_bytes();
    let meter = size_of_val(tables.meter_pairs());
    let mut pixels = Owners::default();
    for run in builder.rows.iter().flatten() {
        match *run {
            RunData::Void(n) => pixels.void += usize::from(n),
            RunData::Left(n) => pixels.left += usize::from(n),
            RunData::Right(n) => pixels.right += usize::from(n),
            RunData::Blend(n, _) => pixels.blend += usize::from(n),
        }
    }
    Report {
        bytes: Bytes {
            total,
            mesh_left,
            mesh_right,
            runs,
            tone,
            meter,
            overlay: 0,
            other: total - mesh_left - mesh_right - runs - tone - meter,
        },
        step: meshes.map(|m| m.map(|m| 1 << m.step_log2)),
        coordinate_error_px: error,
        bend_deg: None,
        tone_error: None,
        scales: None,
        pixels,
        source_bytes_gray8: meshes.map(|m| {
            m.map_or(0, |m| {
                m.source_size_px.iter().map(|s| usize::from(*s)).product()
            })
        }),
    }
}
