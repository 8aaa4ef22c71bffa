//! `tectum design`: mounts and what they see.

mod args;
mod backward;
mod forward;
mod given;
mod measured;
mod pictures;

pub use args::Args;

use crate::report::{Report, Usage};

/// Computes forward, backward, or compares with what was measured.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    if args.wish.given() {
        return backward::run(args);
    }
    if args.wish.margin.is_some() {
        return Err(Usage("--margin goes with --want or --best".into()).into());
    }
    let given = given::Given::of(args)?;
    let mut report = forward::run(args, &given)?;
    let measured = measured::run(args, &given)?;
    if let Some(measured) = measured {
        report.text = format!("{}\n\n{}", report.text.trim_end(), measured.text);
        report.json["measured"] = measured.json;
    }
    Ok(report)
}
