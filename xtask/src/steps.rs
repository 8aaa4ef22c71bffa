//! `cargo xtask test`: everything that must pass.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, bail};

use crate::packages::{self, Need};
use crate::{cameras, figures, firmware, fuzz, repository, tables};

/// How a step ended, if not in an error.
pub enum Outcome {
    /// All went well.
    Passed,
    /// Not possible here; says what is missing.
    Skipped(String),
}

type Step = (&'static str, fn() -> anyhow::Result<Outcome>);

const STEPS: [Step; 11] = [
    ("format", format),
    ("lint", lint),
    ("minimum Rust version", minimum_rust_version),
    ("tests", tests),
    ("documentation", documentation),
    ("shipped tables", || {
        passed(tables::run(&tables::Args::default()))
    }),
    ("README figures", || {
        passed(figures::run(&figures::Args::default()))
    }),
    ("firmware on emulated boards", firmware::test_all),
    ("aarch64, emulated", firmware::aarch64::run),
    ("cameras, emulated", cameras::run),
    ("fuzzing", fuzzing),
];

/// Runs all steps, collects failures, and fails once at the end.
pub fn run() -> anyhow::Result<()> {
    let mut lines = Vec::new();
    let (mut passed, mut failed, mut skipped) = (0, 0, 0);
    for (name, step) in STEPS {
        println!("\n== {name}");
        let start = Instant::now();
        let verdict = match step() {
            Ok(Outcome::Passed) => {
                passed += 1;
                "passed".to_owned()
            }
            Ok(Outcome::Skipped(why)) => {
                skipped += 1;
                format!("skipped: {why}")
            }
            Err(error) => {
                failed += 1;
                format!("FAILED: {error:#}")
            }
        };
        println!("{name}: {verdict}");
        lines.push(format!(
            "{:>5.0} s  {name}: {verdict}",
            start.elapsed().as_secs_f64()
        ));
    }
    println!(
        "\n{}\n{passed} passed, {failed} failed, {skipped} skipped",
        lines.join("\n")
    );
    if failed > 0 {
        bail!("{failed} of {} steps failed", STEPS.len());
    }
    Ok(())
}

fn passed(result: anyhow::Result<()>) -> anyhow::Result<Outcome> {
    result.map(|()| Outcome::Passed)
}

fn format() -> anyhow::Result<Outcome> {
    if !is_there(&["fmt", "--version"]) {
        return Ok(Outcome::Skipped("rustup component add rustfmt".to_owned()));
    }
    cargo(&["fmt", "--all", "--check"])?;
    cargo(&[
        "fmt",
        "--all",
        "--check",
        "--manifest-path",
        "firmware-sim/Cargo.toml",
    ])
}

fn lint() -> anyhow::Result<Outcome> {
    if !is_there(&["clippy", "--version"]) {
        return Ok(Outcome::Skipped("rustup component add clippy".to_owned()));
    }
    cargo(&[
        "clippy",
        "--quiet",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ])
}

/// The version that Cargo.toml promises must build the workspace: either it is the active one, or
/// rustup has it beside.
fn minimum_rust_version() -> anyhow::Result<Outcome> {
    let promised = env!("CARGO_PKG_RUST_VERSION");
    let output = Command::new("rustc")
        .arg("--version")
        .output()
        .context("rustc")?;
    let active = String::from_utf8_lossy(&output.stdout).into_owned();
    if active
        .split([' ', '.'])
        .skip(1)
        .take(2)
        .eq(promised.split('.').take(2))
    {
        println!(
            "the active toolchain is the minimum version: {}",
            active.trim()
        );
        return Ok(Outcome::Passed);
    }
    let toolchain = format!("+{promised}");
    if !is_there(&[&toolchain, "--version"]) {
        let why = format!(
            "rustup toolchain install {promised} (active: {})",
            active.trim()
        );
        return Ok(Outcome::Skipped(why));
    }
    cargo(&[
        &toolchain,
        "check",
        "--quiet",
        "--workspace",
        "--all-targets",
    ])
}

/// For the tests of the preview's page, which say so themselves where it is missing.
const BROWSER: &[Need] = &[Need {
    file: "/usr/bin/chromium",
    package: "chromium",
}];

fn tests() -> anyhow::Result<Outcome> {
    packages::ensure(BROWSER, None);
    cargo(&["test", "--workspace"])
}

fn documentation() -> anyhow::Result<Outcome> {
    let mut command = Command::new("cargo");
    command.env("RUSTDOCFLAGS", "-D warnings");
    run_cargo(command.args(["doc", "--quiet", "--workspace", "--no-deps"]))
}

fn fuzzing() -> anyhow::Result<Outcome> {
    if !fuzz::is_possible() {
        let why = "nightly Rust and `cargo install cargo-fuzz`; its corpus ran as a test";
        return Ok(Outcome::Skipped(why.to_owned()));
    }
    passed(fuzz::run(&fuzz::Args::default()))
}

fn is_there(args: &[&str]) -> bool {
    let mut command = Command::new("cargo");
    let silent = command
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    silent.status().is_ok_and(|status| status.success())
}

fn cargo(args: &[&str]) -> anyhow::Result<Outcome> {
    run_cargo(Command::new("cargo").args(args))
}

fn run_cargo(command: &mut Command) -> anyhow::Result<Outcome> {
    let status = command
        .current_dir(repository())
        .status()
        .context("cargo")?;
    if !status.success() {
        let args: Vec<_> = command.get_args().map(|a| a.to_string_lossy()).collect();
        bail!("cargo {}", args.join(" "));
    }
    Ok(Outcome::Passed)
}
