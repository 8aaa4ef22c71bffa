//! `cargo xtask firmware`: the core on emulated Cortex-M boards.

pub mod aarch64;
mod board;
mod build;
mod emulate;
mod host;
mod proofs;
mod report;
mod snapshot;
mod test;
mod toolchain;

pub use report::figures;

use std::path::PathBuf;

use clap::Subcommand;

use crate::repository;
use crate::steps::Outcome;

/// Arguments of `cargo xtask firmware`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build, emulate and compare every program with its snapshot and with the host
    Test(test::Args),
    /// Print the measured figures (from the snapshots, which `test` keeps true)
    Report(report::Args),
}

/// Runs `cargo xtask firmware`.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    match args.command {
        Command::Test(args) => test::run(&args),
        Command::Report(args) => report::run(&args).map(|()| Outcome::Passed),
    }
}

/// Every program and proof on every board.
pub fn test_all() -> anyhow::Result<Outcome> {
    test::run(&test::Args::default())
}

/// The firmware workspace.
fn workspace() -> PathBuf {
    repository().join("firmware-sim")
}

/// A folder for build products of a cross build, inside the target folder in use.
pub fn target_dir(name: &str) -> PathBuf {
    let base = std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || repository().join("target"),
        |dir| repository().join(PathBuf::from(dir)),
    );
    base.join(name)
}
