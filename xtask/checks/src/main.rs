//! The checks behind `cargo xtask` that need the host crates.

mod cameras;
mod figures;
mod firmware;
mod tables;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use xtask::{Outcome, SKIPPED, SKIPPED_EXIT_CODE};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The checks that need the host crates")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake the shipped tables again and compare them byte for byte
    Tables(tables::Args),
    /// Write the README's table of measured figures and compare it
    Figures(figures::Args),
    /// The core on emulated Cortex-M boards: test, report
    Firmware(firmware::Args),
    /// The built program with the Linux kernel's virtual cameras, in an emulated machine
    Cameras,
}

fn main() -> ExitCode {
    let passed = |result: anyhow::Result<()>| result.map(|()| Outcome::Passed);
    let result = match Cli::parse().command {
        Command::Tables(args) => passed(tables::run(&args)),
        Command::Figures(args) => passed(figures::run(&args)),
        Command::Firmware(args) => firmware::run(args),
        Command::Cameras => cameras::run(),
    };
    match result {
        Ok(Outcome::Passed) => ExitCode::SUCCESS,
        Ok(Outcome::Skipped(why)) => {
            println!("{SKIPPED}{why}");
            ExitCode::from(SKIPPED_EXIT_CODE)
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
