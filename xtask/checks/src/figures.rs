//! `cargo xtask figures`: the README's table of measured figures.

use std::fmt::Write;
use std::fs;

use anyhow::{Context, bail};

use xtask::repository;

use crate::{firmware, tables};

const BEGIN: &str = "<!-- figures: written by `cargo xtask figures --bless` -->\n";
const END: &str = "<!-- end of figures -->\n";

/// Arguments of `cargo xtask figures`.
#[derive(clap::Args, Default)]
pub struct Args {
    /// Write the README instead of comparing it
    #[arg(long)]
    bless: bool,
}

/// Runs `cargo xtask figures`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let path = repository().join("README.md");
    let readme = fs::read_to_string(&path).context("README.md")?;
    let figures = figures()?;
    let (before, rest) = readme
        .split_once(BEGIN)
        .context("README.md has no place for figures")?;
    let (written, after) = rest
        .split_once(END)
        .context("README.md: the figures have no end")?;
    if written == figures {
        println!("README.md holds today's figures");
    } else if args.bless {
        fs::write(&path, format!("{before}{BEGIN}{figures}{END}{after}"))?;
        println!("README.md: figures written");
    } else {
        println!("{figures}");
        bail!("README.md does not hold these figures (--bless)");
    }
    Ok(())
}

fn figures() -> anyhow::Result<String> {
    let mut text = String::from(
        "\n| table | output | step | bytes: mesh left + right, runs, all | position error, max / RMS |\n\
         |---|---|---|---|---|\n",
    );
    for recipe in tables::recipes()? {
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
    text.push('\n');
    text.push_str(&firmware::figures()?);
    text.push('\n');
    Ok(text)
}
