//! Calls of cargo that all agree on profile, packages and features, so that nothing is built twice.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use xtask::packages;
use xtask::{Outcome, SKIPPED, SKIPPED_EXIT_CODE, repository};

/// Cargo in the repository.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.args(arguments).current_dir(repository());
    cargo
}

/// The packages and features of every build here: all, with cameras where they can be built.
pub fn everything() -> Vec<&'static str> {
    let mut arguments = vec!["--workspace"];
    if with_cameras() {
        arguments.extend(["--features", "tectum/v4l2,tectum-capture/v4l2"]);
    }
    arguments
}

/// Whether the Video4Linux bindings can be made here: Linux, with libclang.
pub fn with_cameras() -> bool {
    cfg!(target_os = "linux") && packages::are_there(packages::CAMERA_BUILD)
}

/// Runs it; an error names the command.
pub fn run(command: &mut Command) -> anyhow::Result<()> {
    let status = command.status().with_context(|| text(command))?;
    if !status.success() {
        bail!("failed: {}", text(command));
    }
    Ok(())
}

/// Runs a test program and shows what it prints. Skipped where one of its tests says that it had
/// nothing to do (`tectum_test_data::skip`), which the program itself counts as passed.
pub fn run_tests(command: &mut Command) -> anyhow::Result<Outcome> {
    let mut program = command
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| text(command))?;
    let mut outcome = Outcome::Passed;
    for line in BufReader::new(program.stderr.take().context("no stderr")?).split(b'\n') {
        let line = line?;
        let line = String::from_utf8_lossy(&line);
        eprintln!("{line}");
        if let Some(at) = line.find(SKIPPED) {
            outcome = Outcome::Skipped(line[at + SKIPPED.len()..].to_owned());
        }
    }
    if !program.wait()?.success() {
        bail!("failed: {}", text(command));
    }
    Ok(outcome)
}

/// Whether it can be run and succeeds, in silence.
pub fn succeeds(command: &mut Command) -> bool {
    let silent = command.stdout(Stdio::null()).stderr(Stdio::null());
    silent.status().is_ok_and(|status| status.success())
}

/// A command as one would type it.
pub fn text(command: &Command) -> String {
    let mut words = vec![command.get_program().to_string_lossy()];
    words.extend(command.get_args().map(|word| word.to_string_lossy()));
    words.join(" ")
}

/// Builds and runs a check that needs the host crates, with its own arguments. It says itself why
/// it is skipped.
pub fn check(name: &str, arguments: &[OsString]) -> anyhow::Result<Outcome> {
    let mut build = cargo(&["build", "--bin", "tectum", "--bin", "tectum-checks"]);
    build.args(everything());
    run(&mut build)?;
    let mut check = Command::new(checks());
    check.arg(name).args(arguments).current_dir(repository());
    let status = check.status().with_context(|| text(&check))?;
    if status.code() == Some(i32::from(SKIPPED_EXIT_CODE)) {
        return Ok(Outcome::Skipped(format!("{name}, as said above")));
    }
    if !status.success() {
        bail!("failed: {}", text(&check));
    }
    Ok(Outcome::Passed)
}

/// The program with the checks, once built.
pub fn checks() -> std::path::PathBuf {
    xtask::target_dir("debug").join("tectum-checks")
}
