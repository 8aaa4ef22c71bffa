//! `cargo xtask figures`: the measured figures of `docs/firmware.md`, and those of them that the README shows.

use std::fmt::Write;
use std::fs;

use anyhow::{Context, bail};

use xtask::repository;

use crate::firmware;

const BEGIN: &str = "<!-- figures: written by `cargo xtask figures --bless` -->\n";
const END: &str = "<!-- end of figures -->\n";

/// Arguments of `cargo xtask figures`.
#[derive(clap::Args, Default)]
pub struct Args {
    /// Write the pages instead of comparing them
    #[arg(long)]
    bless: bool,
}

/// Runs `cargo xtask figures`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let firmware = firmware::figures()?;
    let all = format!("{}\n{}\n", tables()?, firmware.all);
    let pages = [
        ("docs/firmware.md", all),
        ("README.md", format!("\n{}\n", firmware.chosen)),
    ];
    // Both are looked at before one that is wrong ends the check.
    let checked = pages.map(|(page, figures)| check(page, &figures, args.bless));
    checked.into_iter().collect()
}

/// Compares a page's figures with today's, or writes them.
fn check(page: &str, figures: &str, bless: bool) -> anyhow::Result<()> {
    let path = repository().join(page);
    let text = fs::read_to_string(&path).with_context(|| page.to_owned())?;
    let (before, rest) = text
        .split_once(BEGIN)
        .with_context(|| format!("{page} has no place for figures"))?;
    let (written, after) = rest
        .split_once(END)
        .with_context(|| format!("{page}: the figures have no end"))?;
    if written == figures {
        println!("{page} holds today's figures");
    } else if bless {
        fs::write(&path, format!("{before}{BEGIN}{figures}{END}{after}"))?;
        println!("{page}: figures written");
    } else {
        println!("{figures}");
        bail!("{page} does not hold these figures (--bless)");
    }
    Ok(())
}

/// What each shipped table takes.
fn tables() -> anyhow::Result<String> {
    let mut text = String::from(
        "\n| table | output | step | bytes: mesh left + right, runs, all | position error, max / RMS |\n\
         |---|---|---|---|---|\n",
    );
    for recipe in crate::tables::recipes()? {
        let report = recipe.bake()?.report;
        let [width, height] = recipe.size_px;
        let bytes = report.bytes;
        let step = report.step[0].map_or_else(|| "-".to_owned(), |step| format!("{step} px"));
        writeln!(
            text,
            "| `{}` | {width}x{height} | {step} | {} + {}, {}, {} | {:.3} / {:.4} px |",
            recipe.file,
            bytes.mesh_left,
            bytes.mesh_right,
            bytes.runs,
            bytes.total,
            report.coordinate_error_px.max,
            report.coordinate_error_px.rms,
        )?;
    }
    Ok(text)
}
