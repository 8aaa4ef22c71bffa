//! `cargo xtask fuzz`: some seconds of fuzzing, on a copy of the corpus.

use std::fs;
use std::process::Command;

use xtask::{Outcome, repository, target_dir};

use crate::cargo;
use crate::jobs::{Job, Kind};

/// How long, where nothing else is said.
pub const SECONDS: u32 = 10;

/// What to do where it is not possible.
pub const ADVICE: &str =
    "rustup toolchain install nightly, cargo install cargo-fuzz; its corpus ran as a test";

/// Whether nightly Rust and cargo-fuzz are here.
pub fn is_possible() -> bool {
    cargo::succeeds(Command::new("cargo").args(["+nightly", "--version"]))
        && cargo::succeeds(Command::new("cargo").args(["fuzz", "--version"]))
}

/// Runs `cargo xtask fuzz`.
pub fn run(seconds: u32) -> anyhow::Result<Outcome> {
    if !is_possible() {
        return Ok(Outcome::Skipped(ADVICE.to_owned()));
    }
    cargo::run(&mut command(seconds)?)?;
    Ok(Outcome::Passed)
}

/// Ten seconds of it, for the gate.
pub fn job() -> anyhow::Result<Job> {
    Ok(Job::new("fuzzing", Kind::Check, command(SECONDS)?))
}

/// What is found goes to a copy: the corpus in the repository stays as it is.
fn command(seconds: u32) -> anyhow::Result<Command> {
    let fuzz = repository().join("tests/fuzz");
    let corpus = target_dir("xtask").join("corpus");
    fs::create_dir_all(&corpus)?;
    for entry in fs::read_dir(fuzz.join("corpus/tables"))? {
        let entry = entry?;
        fs::copy(entry.path(), corpus.join(entry.file_name()))?;
    }
    let mut command = Command::new("cargo");
    command
        .args(["+nightly", "fuzz", "run", "--fuzz-dir", ".", "tables"])
        .arg(corpus)
        .args(["--", "-verbosity=0"])
        .arg(format!("-max_total_time={seconds}"))
        .current_dir(fuzz);
    Ok(command)
}
