//! The core on emulated Cortex-M boards.

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

use xtask::{Outcome, repository};

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

/// The firmware workspace.
fn workspace() -> PathBuf {
    repository().join("firmware-sim")
}
