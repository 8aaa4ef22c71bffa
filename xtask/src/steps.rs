//! `cargo xtask test`: everything that must pass.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context, bail};
use xtask::packages::{
    AARCH64, BOARD_COMPILER, BOARD_EMULATOR, BROWSER, CAMERA_BUILD, CAMERA_MACHINE,
};
use xtask::{Outcome, packages, repository};

use crate::cargo::{self, cargo, everything};
use crate::jobs::{self, Job, Kind};
use crate::seen::Seen;
use crate::tally::Tally;
use crate::{aarch64, campaign, fuzz, programs};

/// Options of `cargo xtask test`.
#[derive(Debug, Default)]
pub struct Options {
    /// Install missing Debian packages.
    pub install: bool,
    /// Say what there is, and run nothing.
    pub list: bool,
    /// Run on boards and aarch64 even where nothing of theirs has changed.
    pub all: bool,
    /// Run one step alone: its name, or that of a job of the last steps.
    pub only: Option<String>,
}

/// Steps and what each proves, in order.
const STEPS: [(&str, &str); 13] = [
    (
        "packages",
        "Debian packages that the steps need are there, or are named",
    ),
    ("format", "all sources are formatted"),
    (
        "minimum Rust version",
        "the promised version of Rust builds the workspace",
    ),
    (
        "lint",
        "clippy finds nothing, in code and tests, with cameras",
    ),
    (
        "build",
        "all programs and tests build, once, for all later steps",
    ),
    (
        "tests",
        "unit, differential, property and snapshot tests, real pictures where they are",
    ),
    ("doctests", "examples in the documentation run"),
    ("documentation", "it builds, and its links lead somewhere"),
    (
        "tables",
        "shipped tables are baked again, the same to the byte",
    ),
    (
        "figures",
        "figures of README and docs/firmware.md are those measured",
    ),
    (
        "firmware",
        "when changed: the core on emulated M4, M7 and M55: bytes, counts, stack, size, no panic path",
    ),
    (
        "aarch64",
        "when changed: tables, core and bake are the same to the byte on an emulated SoC",
    ),
    (
        "cameras",
        "the program with the kernel's virtual cameras, in an emulated machine",
    ),
];
/// Fuzzing is the last job, where there is a fuzzer.
const FUZZING: (&str, &str) = ("fuzzing", "ten seconds of fuzzing the table parser");

/// Names of jobs that take longest, so that they begin first.
const LONGEST: [&str; 7] = [
    "firmware",
    "aarch64",
    "documentation",
    "host/cli/cli",
    "host/stitch/lib",
    "host/calibrate/lib",
    // After `documentation`, for each locks the target folder.
    "doctests",
];

/// Runs the steps, collects failures, and fails once at the end.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if options.list {
        for (name, proves) in STEPS.iter().chain([&FUZZING]) {
            println!("{name:<21} {proves}");
        }
        return Ok(());
    }
    let mut report = Report::default();
    let wanted = |name: &str| options.only.as_deref().is_none_or(|only| only == name);

    if wanted("packages") {
        let allowed = options.install || std::env::var_os("CI").is_some_and(|ci| ci == "true");
        report.step("packages", || {
            let needs = [
                BROWSER,
                BOARD_COMPILER,
                BOARD_EMULATOR,
                AARCH64,
                CAMERA_BUILD,
                CAMERA_MACHINE,
            ];
            packages::install(&needs.concat(), allowed);
            Ok(Outcome::Passed)
        });
    }
    for (name, step) in [
        ("format", format as fn() -> anyhow::Result<Outcome>),
        ("minimum Rust version", minimum_rust_version),
        ("lint", lint),
    ] {
        if wanted(name) {
            report.step(name, step);
        }
    }
    let jobs = report.jobs(options)?;
    if !jobs.is_empty() {
        report.beside_each_other(jobs)?;
    }
    report.end()
}

/// What has been done.
#[derive(Default)]
struct Report {
    lines: Vec<String>,
    total: Tally,
    failed: Vec<String>,
    seen: Seen,
}

impl Report {
    fn step(&mut self, name: &str, step: impl FnOnce() -> anyhow::Result<Outcome>) {
        println!("\n== {name}");
        let start = Instant::now();
        let outcome = step();
        let verdict = match &outcome {
            Ok(Outcome::Passed) => "passed".to_owned(),
            Ok(Outcome::Skipped(why)) => format!("skipped: {why}"),
            Err(error) => format!("FAILED: {error:#}"),
        };
        println!("{name}: {verdict}");
        let seconds = start.elapsed().as_secs_f64();
        self.lines
            .push(format!("{seconds:>5.0} s  {name}: {verdict}"));
        self.count(name, Tally::whole(name, &outcome));
    }

    fn count(&mut self, name: &str, tally: Tally) {
        if tally.failed > 0 {
            self.failed.push(name.to_owned());
        }
        self.total.add(tally);
    }

    /// Builds what jobs need; the jobs, or the one that is wanted.
    fn jobs(&mut self, options: &Options) -> anyhow::Result<Vec<Job>> {
        let only = options.only.as_deref();
        let before = ["packages", "format", "minimum Rust version", "lint"];
        if only.is_some_and(|only| before.contains(&only)) {
            return Ok(Vec::new());
        }
        let mut built = Vec::new();
        self.step("build", || {
            println!("all programs and tests of the workspace, in one profile");
            built = programs::build()?;
            Ok(Outcome::Passed)
        });
        if !self.failed.is_empty() && built.is_empty() {
            return Ok(Vec::new());
        }
        self.seen = Seen::new(&built);
        let runs_all = options.all || only.is_some();
        let before = built.len();
        built.retain(|program| runs_all || !self.seen.has_passed(&program.name));
        if built.len() < before {
            let what = format!("{} test programs", before - built.len());
            self.unchanged(&what, "they passed in this target folder");
        }
        let mut jobs: Vec<Job> = built.into_iter().map(test_program).collect();
        jobs.push(doctests());
        jobs.push(documentation());
        jobs.extend(["tables", "figures"].map(|name| check(name, &[])));
        // Who asks for one of them gets it whole.
        let is_asked = |name: &str| options.all || only == Some(name);
        if !is_asked("firmware") && campaign::boards_are_current() {
            self.unchanged("firmware", "campaign `boards` passed");
        } else {
            jobs.push(check("firmware", &["test"]));
        }
        if !is_asked("aarch64") && campaign::aarch64_is_current() {
            self.unchanged("aarch64", "campaign `aarch64` passed");
        } else if packages::are_there(AARCH64) {
            jobs.push(Job::new("aarch64", Kind::Tests, aarch64::command()));
        } else {
            self.skip("aarch64", packages::advice(AARCH64));
        }
        if fuzz::is_possible() {
            jobs.push(fuzz::job()?);
        } else {
            self.skip("fuzzing", fuzz::ADVICE.to_owned());
        }
        // Frames come in real time there: it goes before all others.
        let mut cameras = check("cameras", &[]);
        cameras.is_urgent = true;
        jobs.push(cameras);
        let all = "tests".to_owned();
        jobs.retain(|job| match only {
            None => true,
            Some(only) => only == job.name || (only == all && job.name.contains('/')),
        });
        if let Some(only) = only
            && jobs.is_empty()
            && only != "build"
        {
            bail!("no step or test program `{only}`: `cargo xtask test --list` names the steps");
        }
        let rank = |job: &Job| LONGEST.iter().position(|name| *name == job.name);
        jobs.sort_by_key(|job| rank(job).unwrap_or(LONGEST.len()));
        Ok(jobs)
    }

    fn skip(&mut self, name: &str, why: String) {
        let outcome = Ok(Outcome::Skipped(why));
        self.count(name, Tally::whole(name, &outcome));
    }

    /// Says what is left out, because it has passed as it is.
    fn unchanged(&mut self, what: &str, since: &str) {
        let line = format!("{what}: unchanged since {since} (--all runs all)");
        println!("{line}");
        self.lines.push(format!("    0 s  {line}"));
    }

    fn beside_each_other(&mut self, jobs: Vec<Job>) -> anyhow::Result<()> {
        println!(
            "\n== {} jobs, as many at a time as there are processors",
            jobs.len()
        );
        let start = Instant::now();
        let mut done = jobs::run(jobs)?;
        done.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        for job in done {
            self.lines.push(format!(
                "{:>5.0} s  {}: {}",
                job.seconds, job.name, job.tally
            ));
            // A test that is skipped today may find what it needs tomorrow.
            if job.tally.failed == 0 && job.tally.skipped.is_empty() {
                self.seen.pass(&job.name);
            }
            self.count(&job.name, job.tally);
        }
        self.seen.keep();
        let seconds = start.elapsed().as_secs_f64();
        self.lines.push(format!("{seconds:>5.0} s  together"));
        Ok(())
    }

    fn end(self) -> anyhow::Result<()> {
        println!("\n{}\n", self.lines.join("\n"));
        for (name, why) in &self.total.skipped {
            println!("skipped {name}: {why}");
        }
        if self.total.ignored > 0 {
            println!(
                "{} tests belong to campaigns: `cargo xtask campaign --list`",
                self.total.ignored
            );
        }
        let due = campaign::due();
        if !due.is_empty() {
            println!(
                "campaigns whose part has changed since they passed: {}",
                due.join(", ")
            );
        }
        println!("{}", self.total);
        if !self.failed.is_empty() {
            bail!("failed: {}", self.failed.join(", "));
        }
        Ok(())
    }
}

fn test_program(program: programs::Program) -> Job {
    Job::new(&program.name, Kind::Tests, program.command())
}

fn doctests() -> Job {
    let mut command = cargo(&["test", "--doc"]);
    command.args(everything());
    Job::new("doctests", Kind::Tests, command)
}

fn documentation() -> Job {
    let mut command = cargo(&["doc", "--no-deps"]);
    command
        .args(everything())
        .env("RUSTDOCFLAGS", "-D warnings");
    Job::new("documentation", Kind::Check, command)
}

/// A check of the program with the host crates.
fn check(name: &str, arguments: &[&str]) -> Job {
    let mut command = Command::new(cargo::checks());
    command.arg(name).args(arguments).current_dir(repository());
    Job::new(name, Kind::Check, command)
}

fn format() -> anyhow::Result<Outcome> {
    if !cargo::succeeds(&mut cargo(&["fmt", "--version"])) {
        return Ok(Outcome::Skipped("rustup component add rustfmt".to_owned()));
    }
    for manifest in ["Cargo.toml", "firmware-sim/Cargo.toml"] {
        let arguments = ["fmt", "--all", "--check", "--manifest-path", manifest];
        cargo::run(&mut cargo(&arguments))?;
    }
    Ok(Outcome::Passed)
}

fn lint() -> anyhow::Result<Outcome> {
    if !cargo::succeeds(&mut cargo(&["clippy", "--version"])) {
        return Ok(Outcome::Skipped("rustup component add clippy".to_owned()));
    }
    println!("checks all dependencies, then all code and tests of the workspace");
    let mut clippy = cargo(&["clippy", "--all-targets"]);
    cargo::run(clippy.args(everything()).args(["--", "-D", "warnings"]))?;
    Ok(Outcome::Passed)
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
    if !cargo::succeeds(&mut cargo(&[&toolchain, "--version"])) {
        let why = format!(
            "rustup toolchain install {promised} (active: {})",
            active.trim()
        );
        return Ok(Outcome::Skipped(why));
    }
    cargo::run(&mut cargo(&[
        &toolchain,
        "check",
        "--quiet",
        "--workspace",
        "--all-targets",
    ]))?;
    Ok(Outcome::Passed)
}
