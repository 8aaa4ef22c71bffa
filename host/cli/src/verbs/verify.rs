//! `tectum verify`: the core against both references.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;
use serde_json::json;
use tectum_bake::{Verification, verify};
use tectum_scene::Scene;

use crate::frames::Frames;
use crate::progress::Progress;
use crate::report::{Report, max_rms};
use crate::{files, pool};

/// The core against both references: bit for bit, and against the rig's camera models
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum verify fish.tct                                   on made-up frames\n  \
    tectum verify fish.tct --rig rig.toml                    and against the rig, in the pool\n  \
    tectum verify fish.tct --rig rig.toml --left l.png --right r.png --json\n\n\
    Compares every byte in all pixel formats, both samplers, both ways to run. Exit code 1 if\n\
    any byte differs.")]
pub struct Args {
    /// Table
    table: PathBuf,
    /// Rig that the table was baked from: checks positions and pixels against its models
    #[arg(long)]
    rig: Option<PathBuf>,
    /// Picture of the left eye
    #[arg(long, value_name = "A")]
    left: Option<PathBuf>,
    /// Picture of the right eye
    #[arg(long, value_name = "B")]
    right: Option<PathBuf>,
}

/// Verifies.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let bytes = files::read(&args.table)?;
    let tables = files::table(&bytes, &args.table)?;
    let rig = args.rig.as_deref().map(files::rig).transpose()?;
    let progress = Progress::new(2);
    progress.step("frames");
    let (frames, source) = if args.left.is_some() || args.right.is_some() {
        let frames = Frames::load(&tables, args.left.as_deref(), args.right.as_deref())?;
        (frames, "given")
    } else if let Some(rig) = &rig {
        let scene = Scene::new(&pool::furnished(rig))?;
        // One ray a pixel: what is in the picture matters little here.
        (
            pool::frames(&pool::both_eyes(&scene, rig, Default::default(), 0, 1)?),
            "pool",
        )
    } else {
        (Frames::noise(&tables), "noise")
    };
    progress.step("comparing every byte");
    let verification = verify(&tables, rig.as_ref(), frames.pair())
        .with_context(|| args.table.display().to_string())?;
    drop(progress);
    let mut json = serde_json::to_value(&verification)?;
    json["frames"] = json!(source);
    // Scripts find these keys whether there is a rig or not.
    for key in ["coordinate_error_px", "pixel_error_lsb"] {
        json[key] = json[key].take();
    }
    Ok(Report {
        text: format!(
            "{}: {} output pixels, frames: {source}\n{}",
            args.table.display(),
            verification.pixels,
            in_words(&verification)
        ),
        json,
        failure: (verification.mismatches > 0).then(|| {
            format!(
                "{}: {} bytes differ from the reference: a bug of this build, please report it \
                 with the table",
                args.table.display(),
                verification.mismatches
            )
        }),
    })
}

/// The result for a person.
pub fn in_words(verification: &Verification) -> String {
    let mut text = String::new();
    for format in &verification.formats {
        let _ = writeln!(
            text,
            "{:<8} {:>10} bytes compared, {} differ",
            format.format.name(),
            format.bytes_compared,
            format.mismatches
        );
    }
    let _ = write!(
        text,
        "mismatches: {}\nrounding          {:.3} LSB max",
        verification.mismatches, verification.rounding_error_lsb
    );
    if let Some(error) = &verification.coordinate_error_px {
        let _ = write!(text, "\ncoordinate error  {}", max_rms(error, "px"));
    }
    if let Some(error) = &verification.pixel_error_lsb {
        let _ = write!(
            text,
            "\npixel error       {:.2} LSB max, {:.3} LSB mean (follows from the coordinate error)",
            error.max, error.mean
        );
    }
    text
}
