//! `cargo xtask firmware test`.

use std::path::PathBuf;

use anyhow::{Context, anyhow, bail};
use clap::ValueEnum;
use console::style;

use super::board::Board;
use super::build::Builder;
use super::snapshot::{self, Compare};
use super::toolchain::Toolchain;
use super::{emulate, host, proofs, workspace};
use xtask::Outcome;

/// Programs that run, and how their output is compared.
const PROGRAMS: [(&str, Compare); 7] = [
    ("stitch", Compare::Exact),
    ("random", Compare::Exact),
    ("tone", Compare::Exact),
    ("overlay", Compare::Exact),
    ("lookup", Compare::Exact),
    ("counts", Compare::Figures),
    ("stack", Compare::Figures),
];

/// Arguments of `cargo xtask firmware test`.
#[derive(clap::Args, Default)]
pub struct Args {
    /// Rewrite the snapshots that differ
    #[arg(long)]
    bless: bool,
    /// One board alone
    #[arg(long)]
    board: Option<Board>,
    /// One program alone: stitch, random, tone, overlay, lookup, counts, stack or proofs
    name: Option<String>,
}

/// Runs everything asked for, collects what failed, and fails once.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let known = PROGRAMS.iter().map(|(name, _)| *name).chain(["proofs"]);
    if let Some(name) = &args.name
        && !known.clone().any(|known| known == name)
    {
        bail!(
            "no program `{name}`: there are {}",
            known.collect::<Vec<_>>().join(", ")
        );
    }
    let boards = args
        .board
        .map_or_else(|| Board::value_variants().to_vec(), |board| vec![board]);
    let toolchain = match Toolchain::find(&boards) {
        Ok(toolchain) => toolchain,
        Err(what_to_do) => {
            return Ok(Outcome::Skipped(what_to_do));
        }
    };
    let failures: Vec<String> = boards
        .into_iter()
        .flat_map(|board| test_board(Builder { toolchain, board }, args))
        .filter_map(|(name, result)| print_result(name, result))
        .collect();
    if failures.is_empty() {
        return Ok(Outcome::Passed);
    }
    Err(anyhow!(
        "{} failed: {}",
        failures.len(),
        failures.join(", ")
    ))
}

fn test_board(builder: Builder, args: &Args) -> Vec<(String, anyhow::Result<()>)> {
    let board = builder.board.name();
    let wanted = |name: &str| args.name.as_deref().is_none_or(|only| only == name);
    let mut results = Vec::new();
    let programs: Vec<_> = PROGRAMS.iter().filter(|(name, _)| wanted(name)).collect();
    if !programs.is_empty() {
        match builder.build("tectum-firmware-sim") {
            Ok(()) => results.extend(programs.into_iter().map(|&(name, compare)| {
                (
                    format!("{board} {name}"),
                    test_program(builder, name, compare, args.bless),
                )
            })),
            Err(error) => results.push((format!("{board} build"), Err(error))),
        }
    }
    if wanted("proofs") {
        let named = proofs::check(builder, args.bless).into_iter();
        results.extend(named.map(|(name, result)| (format!("{board} {name}"), result)));
    }
    results
}

fn test_program(builder: Builder, name: &str, compare: Compare, bless: bool) -> anyhow::Result<()> {
    let mut lines = emulate::run(builder.board, &builder.program(name)).context("emulating")?;
    if let Some(expected) = host::lines(builder.board, name)? {
        host::compare(&expected, &lines)?;
    }
    if compare == Compare::Figures {
        lines.insert(0, builder.toolchain.version());
    }
    let path = snapshot::path(&programs_folder(), name, builder.board.name());
    snapshot::check(&path, &lines, compare, bless)
}

/// Where the programs and their snapshots are.
pub fn programs_folder() -> PathBuf {
    workspace().join("src/bin")
}

/// Prints the outcome; the name, if it failed.
fn print_result(name: String, result: anyhow::Result<()>) -> Option<String> {
    match result {
        Ok(()) => {
            println!("{} {name}", style("ok").green());
            None
        }
        Err(error) => {
            println!("{} {name}: {error:#}", style("FAILED").red());
            Some(name)
        }
    }
}
