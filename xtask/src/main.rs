//! One named command for each chore and CI step.

mod firmware;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

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
    /// The core on emulated Cortex-M boards: test, report
    Firmware(firmware::Args),
    /// The tests of the tables and the core on emulated aarch64
    Aarch64,
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Firmware(args) => firmware::run(args),
        Command::Aarch64 => firmware::aarch64::run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
