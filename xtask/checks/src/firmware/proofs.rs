//! What is proven by linking and read from the linked files: no panic path, and code size.

use std::fs;

use anyhow::{Context, bail};
use object::{Object, ObjectSegment};

use super::build::Builder;
use super::snapshot::{self, Compare};
use super::workspace;

/// The symbol that the proofs' panic handler calls and nobody defines.
const PANIC_SYMBOL: &str = "a_panic_path_is_left";
/// Design budget for one format.
const BUDGET_BYTES: u64 = 16 * 1024;
/// Programs of one format each, which the budget is for; what `size_none` holds is start-up and table.
const FORMATS: [&str; 4] = ["gray8", "rgb565", "yuyv", "rgb8"];

/// Links all proofs for a board and checks them.
pub fn check(builder: Builder, bless: bool) -> Vec<(&'static str, anyhow::Result<()>)> {
    let linked = builder
        .build("tectum-proofs")
        .context("a panic path is left, or worse");
    if linked.is_err() {
        return vec![("no panic path", linked)];
    }
    vec![
        ("no panic path", Ok(())),
        ("a panic path is noticed", deliberate_panic_fails(builder)),
        ("code size", code_size(builder, bless)),
    ]
}

/// The same program with one panic added must not link, for that very reason.
fn deliberate_panic_fails(builder: Builder) -> anyhow::Result<()> {
    let output = builder.output(&[
        "-p",
        "tectum-proofs",
        "--bin",
        "nopanic",
        "--features",
        "deliberate-panic",
    ])?;
    let text = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        bail!("a program with a panic in it links: `nopanic` proves nothing");
    }
    if !text.contains(PANIC_SYMBOL) {
        bail!(
            "failed to link, but not for the panic:\n{}",
            text.trim_end()
        );
    }
    Ok(())
}

fn code_size(builder: Builder, bless: bool) -> anyhow::Result<()> {
    let baseline = flash_bytes(builder, "size_none")?;
    let size =
        |program: &str| anyhow::Ok(flash_bytes(builder, &format!("size_{program}"))? - baseline);
    let mut lines = vec![builder.toolchain.version()];
    for part in ["parse", "overlay", "lookup", "targets", "exposure"] {
        lines.push(format!("{part} {} bytes", size(part)?));
    }
    let mut over_budget = Vec::new();
    for format in FORMATS {
        let bytes = size(format)?;
        lines.push(format!("{format} {bytes} bytes"));
        over_budget.extend((bytes > BUDGET_BYTES).then(|| format!("{format} {bytes}")));
    }
    // Two formats in one program.
    lines.push(format!("nv12 {} bytes", size("nv12")?));
    let path = snapshot::path(&workspace().join("proofs"), "size", builder.board.name());
    snapshot::check(&path, &lines, Compare::Figures, bless)?;
    if !over_budget.is_empty() {
        bail!(
            "over the budget of {BUDGET_BYTES} bytes: {}",
            over_budget.join(", ")
        );
    }
    Ok(())
}

/// Bytes that a program takes in flash: code, constants and initial values.
fn flash_bytes(builder: Builder, program: &str) -> anyhow::Result<u64> {
    let path = builder.program(program);
    let bytes = fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
    let file = object::File::parse(&*bytes)?;
    Ok(file.segments().map(|segment| segment.file_range().1).sum())
}
