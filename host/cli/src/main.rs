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
mod shown;
mod verbs;

use std::process::ExitCode;

use clap::Parser;

use crate::report::{Usage, explain, print, print_error};
use crate::verbs::Verb;

/// Exit code of arguments that make no sense.
const WRONG_USAGE: u8 = 2;

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
    /// Print exactly one JSON object on stdout, `{"error": ...}` where something fails
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    verb: Verb,
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return wrong_usage(&error),
    };
    match cli.verb.run() {
        Ok(report) => {
            if let Err(error) = print(&report, cli.json) {
                eprintln!("error: the report cannot be printed: {error}");
                return ExitCode::FAILURE;
            }
            match report.failure {
                None => ExitCode::SUCCESS,
                Some(failure) => {
                    eprintln!("error: {failure}");
                    ExitCode::FAILURE
                }
            }
        }
        Err(error) => {
            print_error(&explain(&error), cli.json);
            if error.is::<Usage>() {
                ExitCode::from(WRONG_USAGE)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

/// What clap says of the arguments: help and version too, which are no error.
fn wrong_usage(error: &clap::Error) -> ExitCode {
    // Arguments that cannot be parsed do not say whether JSON is wanted: look for it.
    let json = std::env::args_os().any(|argument| argument == "--json");
    if error.use_stderr() && json {
        let text = error.render().to_string();
        print_error(text.trim_start_matches("error: ").trim_end(), true);
        return ExitCode::from(WRONG_USAGE);
    }
    match error.print() {
        Ok(()) if !error.use_stderr() => ExitCode::SUCCESS,
        Err(cause) if cause.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Ok(()) => ExitCode::from(WRONG_USAGE),
        Err(_) => ExitCode::FAILURE,
    }
}
