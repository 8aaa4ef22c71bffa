//! `cargo xtask fuzz`: some seconds of fuzzing, on a copy of the corpus.

use std::process::{Command, Stdio};

use anyhow::{Context, bail};

use crate::repository;

/// Arguments of `cargo xtask fuzz`.
#[derive(clap::Args)]
pub struct Args {
    /// How long to fuzz, seconds
    #[arg(long, default_value_t = 10)]
    seconds: u32,
}

impl Default for Args {
    fn default() -> Self {
        Self { seconds: 10 }
    }
}

/// Whether nightly Rust and cargo-fuzz are here.
pub fn is_possible() -> bool {
    let quiet = |command: &mut Command| {
        let silent = command.stdout(Stdio::null()).stderr(Stdio::null());
        silent.status().is_ok_and(|status| status.success())
    };
    quiet(Command::new("cargo").args(["+nightly", "--version"]))
        && quiet(Command::new("cargo").args(["fuzz", "--version"]))
}

/// Runs `cargo xtask fuzz`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    if !is_possible() {
        bail!("fuzzing needs nightly Rust and `cargo install cargo-fuzz`");
    }
    let fuzz = repository().join("tests/fuzz");
    // The corpus in the repository stays as it is: what is found goes to a copy.
    let corpus = tempfile::tempdir()?;
    for entry in std::fs::read_dir(fuzz.join("corpus/tables"))? {
        let entry = entry?;
        std::fs::copy(entry.path(), corpus.path().join(entry.file_name()))?;
    }
    let status = Command::new("cargo")
        .args(["+nightly", "fuzz", "run", "--fuzz-dir", ".", "tables"])
        .arg(corpus.path())
        .args([
            "--",
            "-verbosity=0",
            &format!("-max_total_time={}", args.seconds),
        ])
        .current_dir(&fuzz)
        .status()
        .context("cargo fuzz")?;
    if !status.success() {
        bail!("the fuzzer found a failure: see tests/fuzz/artifacts");
    }
    Ok(())
}
