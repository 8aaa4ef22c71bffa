//! Command line of Tectum: glue between the crates, no logic of its own.

mod areas;
mod args;
mod boards;
mod cameras;
mod detecting;
mod directions;
mod draw;
mod files;
mod frames;
mod instructions;
mod paired;
mod pictures;
mod pool;
mod progress;
mod ranges;
mod report;
mod rig_files;
mod shown;
mod verbs;

use std::process::ExitCode;

use clap::Parser;

use crate::report::{Usage, explain, print};
use crate::verbs::Verb;

/// Stitches two fisheye eyes into one wide picture, from tables of a few kilobytes.
#[derive(Parser)]
#[command(
    name = "tectum",
    version,
    after_help = "EXAMPLES:\n  \
        tectum demo                            everything, with nothing plugged in\n  \
        tectum bake rig.toml -o fish.tct       a rig to a table\n  \
        tectum stitch fish.tct --left l.png --right r.png -o out.png --scales\n\n\
        Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Cli {
    /// Print exactly one JSON object on stdout
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    verb: Verb,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match cli.verb.run() {
        Ok(report) => {
            print(&report, cli.json);
            match report.failure {
                None => ExitCode::SUCCESS,
                Some(failure) => {
                    eprintln!("error: {failure}");
                    ExitCode::FAILURE
                }
            }
        }
        Err(error) => {
            eprintln!("error: {}", explain(&error));
            if error.is::<Usage>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}
