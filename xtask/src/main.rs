//! One named command for each chore and CI step.

mod cameras;
mod figures;
mod firmware;
mod fuzz;
mod packages;
mod steps;
mod tables;

use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use steps::Outcome;

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    about = "One named command for each chore and CI step"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Everything that must pass, in order; what it needs it installs, or says what to install
    Test,
    /// Bake the shipped tables again and compare them byte for byte
    Tables(tables::Args),
    /// Write the README's table of measured figures and compare it
    Figures(figures::Args),
    /// Fuzz the table parser for some seconds, where nightly Rust and cargo-fuzz are present
    Fuzz(fuzz::Args),
    /// The core on emulated Cortex-M boards: test, report
    Firmware(firmware::Args),
    /// The tests of the tables and the core on emulated aarch64
    Aarch64,
    /// The built program with the Linux kernel's virtual cameras, in an emulated machine
    Cameras,
}

fn main() -> ExitCode {
    let passed = |result: anyhow::Result<()>| result.map(|()| Outcome::Passed);
    let result = match Cli::parse().command {
        Command::Test => passed(steps::run()),
        Command::Tables(args) => passed(tables::run(&args)),
        Command::Figures(args) => passed(figures::run(&args)),
        Command::Fuzz(args) => passed(fuzz::run(&args)),
        Command::Firmware(args) => firmware::run(args),
        Command::Aarch64 => firmware::aarch64::run(),
        Command::Cameras => cameras::run(),
    };
    match result {
        Ok(Outcome::Passed) => ExitCode::SUCCESS,
        Ok(Outcome::Skipped(why)) => {
            println!("skipped: {why}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The repository's top folder.
fn repository() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}
