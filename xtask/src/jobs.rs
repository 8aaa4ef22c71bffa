//! Jobs that run beside each other until none is left, each with its output in a file.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::Context;
use xtask::{Outcome, SKIPPED, SKIPPED_EXIT_CODE, target_dir};

use crate::cargo;
use crate::tally::Tally;

/// How a job's outcome is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It prints results of tests.
    Tests,
    /// It passes, fails or is skipped as a whole.
    Check,
}

/// A command to run.
#[derive(Debug)]
pub struct Job {
    /// Its name.
    pub name: String,
    /// How to read its outcome.
    pub kind: Kind,
    /// What is run.
    pub command: Command,
    /// Whether it runs at full priority; the others wait for it where processors are few.
    pub is_urgent: bool,
}

impl Job {
    /// A job that is not urgent.
    pub fn new(name: &str, kind: Kind, command: Command) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            command,
            is_urgent: false,
        }
    }
}

/// How a job ended.
#[derive(Debug)]
pub struct Done {
    /// The job's name.
    pub name: String,
    /// How long it took.
    pub seconds: f64,
    /// What came.
    pub tally: Tally,
}

/// Runs `jobs` in their order, as many at a time as there are processors, and urgent ones beside them
/// from the start. Says when each ends and prints the output of those that fail; all output is kept in
/// the target folder's `xtask`.
pub fn run(jobs: Vec<Job>) -> anyhow::Result<Vec<Done>> {
    let workers = std::thread::available_parallelism().map_or(2, usize::from);
    fs::create_dir_all(target_dir("xtask")).context("a folder for logs")?;
    let (urgent, others): (Vec<_>, Vec<_>) = jobs.into_iter().partition(|job| job.is_urgent);
    let queue = Mutex::new(VecDeque::from(others));
    let done = Mutex::new(Vec::new());
    let next = || queue.lock().ok()?.pop_front();
    let end = |job| {
        let ended = run_one(job);
        if let Ok(mut done) = done.lock() {
            done.push(ended);
        }
    };
    std::thread::scope(|scope| {
        for job in urgent {
            scope.spawn(|| end(job));
        }
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(job) = next() {
                    end(job);
                }
            });
        }
    });
    Ok(done.into_inner().unwrap_or_default())
}

fn run_one(mut job: Job) -> Done {
    let start = Instant::now();
    let log = target_dir("xtask").join(job.name.replace('/', "-") + ".log");
    let outcome = (|| {
        let file = File::create(&log)?;
        job.command.stdout(file.try_clone()?).stderr(file);
        let mut child = job.command.spawn()?;
        if !job.is_urgent {
            // Without `renice` all are alike.
            let id = child.id().to_string();
            let _ = cargo::succeeds(Command::new("renice").args(["-n", "10", "-p", &id]));
        }
        anyhow::Ok(child.wait()?)
    })();
    let bytes = fs::read(&log).unwrap_or_default();
    let printed = String::from_utf8_lossy(&bytes);
    let skipped_code = Some(i32::from(SKIPPED_EXIT_CODE));
    let verdict = match outcome {
        Ok(status) if status.success() => Ok(Outcome::Passed),
        Ok(status) if job.kind == Kind::Check && status.code() == skipped_code => {
            let why = printed.lines().rev().find_map(|l| l.strip_prefix(SKIPPED));
            Ok(Outcome::Skipped(
                why.unwrap_or("it does not say why").to_owned(),
            ))
        }
        Ok(status) => Err(anyhow::anyhow!("{status}")),
        Err(error) => Err(error),
    };
    let mut tally = match job.kind {
        Kind::Tests => Tally::of_tests(&job.name, &printed),
        Kind::Check => Tally::whole(&job.name, &verdict),
    };
    if let Err(error) = &verdict {
        // A program that broke off has printed no count of its failures.
        tally.failed = tally.failed.max(1);
        println!(
            "---- {} failed: {error:#}\n{}",
            job.name,
            printed.trim_end()
        );
        println!("---- end of {}, also in {}", job.name, log.display());
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{seconds:>5.0} s  {}: {tally}", job.name);
    Done {
        name: job.name,
        seconds,
        tally,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(name: &str, kind: Kind, script: &str) -> Job {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Job::new(&format!("unit/{name}"), kind, command)
    }

    #[test]
    fn every_end_of_a_job_is_told_apart() {
        let jobs = vec![
            job("passes", Kind::Check, "exit 0"),
            job("skips", Kind::Check, "echo skipped: no camera; exit 77"),
            job("fails", Kind::Check, "exit 1"),
            job("breaks", Kind::Tests, "kill -9 $$"),
            job(
                "counts",
                Kind::Tests,
                "echo 'test result: ok. 7 passed; 0 failed; 0 ignored'",
            ),
        ];
        let done = run(jobs).unwrap();
        let of = |name: &str| {
            &done
                .iter()
                .find(|d| d.name == format!("unit/{name}"))
                .unwrap()
                .tally
        };
        assert_eq!(of("passes").passed, 1);
        assert_eq!(of("skips").skipped["unit/skips"], "no camera");
        assert_eq!(of("fails").failed, 1);
        assert_eq!(of("breaks").failed, 1);
        assert_eq!(of("counts").passed, 7);
    }
}
