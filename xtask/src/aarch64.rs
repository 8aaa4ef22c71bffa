//! `cargo xtask aarch64`: what can differ on the SoC side's processor, emulated: tables, core and
//! its kernels, the bytes that the baker writes.

use std::process::Command;

use xtask::packages::{self, AARCH64};
use xtask::{Outcome, debian, repository, target_dir};

use crate::cargo;

const TARGET: &str = "aarch64-unknown-linux-gnu";

/// Unit tests of tables and core, the core against its references, shipped tables baked again.
const TESTS: [&str; 6] = [
    "-p",
    "tectum-tables",
    "-p",
    "tectum-core",
    "-p",
    "tectum-exact",
];

/// Builds the tests with Debian's cross compiler and runs them under user-mode QEMU.
pub fn run() -> anyhow::Result<Outcome> {
    if !packages::are_there(AARCH64) {
        return Ok(Outcome::Skipped(packages::advice(AARCH64)));
    }
    cargo::run(&mut command())?;
    Ok(Outcome::Passed)
}

/// The tests with a fifth of the random cases, as one command.
pub fn command() -> Command {
    let mut tests = all();
    tests.env("TECTUM_EMULATED", "1");
    tests
}

/// The tests with all random cases and those of campaigns.
pub fn campaign() -> Command {
    let mut tests = all();
    tests.args(["--", "--include-ignored"]);
    tests
}

fn all() -> Command {
    let mut cargo = debian::cargo();
    cargo
        .args(["test", "--locked", "--lib", "--tests", "--target", TARGET])
        .arg("--target-dir")
        .arg(target_dir("aarch64"))
        .args(TESTS)
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER",
            "aarch64-linux-gnu-gcc",
        )
        // With the cross libraries of libc6-dev-arm64-cross in place of the real ones, starting a
        // thread never returns.
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER",
            "qemu-aarch64 -L /",
        )
        .current_dir(repository());
    cargo
}
