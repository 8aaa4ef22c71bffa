//! What passed, failed and was skipped, read from what programs print.

use std::collections::BTreeMap;

use xtask::SKIPPED;

/// Counts of one job or of all.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Tally {
    /// Checks and tests that passed.
    pub passed: usize,
    /// That failed.
    pub failed: usize,
    /// That could not be made here, by name, and why.
    pub skipped: BTreeMap<String, String>,
    /// Tests that are part of a campaign.
    pub ignored: usize,
}

impl Tally {
    /// Of a job that has no tests of its own: it passed, failed or was skipped as a whole.
    pub fn whole(name: &str, outcome: &anyhow::Result<xtask::Outcome>) -> Self {
        let mut tally = Self::default();
        match outcome {
            Ok(xtask::Outcome::Passed) => tally.passed = 1,
            Ok(xtask::Outcome::Skipped(why)) => {
                tally.skipped.insert(name.to_owned(), why.clone());
            }
            Err(_) => tally.failed = 1,
        }
        tally
    }

    /// Of what Rust's test programs printed: `test result: ok. 3 passed; 0 failed; 1 ignored; …`, and
    /// `skipped: NAME: why` of tests that had nothing to do, which libtest counts as passed.
    pub fn of_tests(program: &str, printed: &str) -> Self {
        let mut tally = Self::default();
        for line in printed.lines() {
            if let Some(counts) = line.strip_prefix("test result: ") {
                let count = |what: &str| {
                    let words: Vec<&str> = counts.split([' ', ';', '.']).collect();
                    let at = words.iter().position(|word| *word == what);
                    at.and_then(|at| words.get(at.checked_sub(1)?)?.parse().ok())
                        .unwrap_or(0)
                };
                tally.passed += count("passed");
                tally.failed += count("failed");
                tally.ignored += count("ignored");
            } else if let Some(at) = line.find(SKIPPED) {
                let (test, why) = line[at + SKIPPED.len()..]
                    .split_once(": ")
                    .unwrap_or((program, "no reason given"));
                let name = format!("{program} {test}");
                tally.skipped.insert(name, why.to_owned());
            }
        }
        tally.passed = tally.passed.saturating_sub(tally.skipped.len());
        tally
    }

    /// Adds another's.
    pub fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
        self.skipped.extend(other.skipped);
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            passed,
            failed,
            skipped,
            ..
        } = self;
        write!(
            f,
            "{passed} passed, {failed} failed, {} skipped",
            skipped.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_that_skips_is_counted_once_and_not_as_passed() {
        let printed = "\nrunning 4 tests\ntest a ... skipped: a: no pictures here\nok\n\
            skipped: a: no pictures there\nskipped: b::c: no browser\ntest b::c ... ok\n\
            test result: ok. 4 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out; finished in 1s\n";
        let tally = Tally::of_tests("t", printed);
        assert_eq!((tally.passed, tally.failed, tally.ignored), (2, 0, 2));
        assert_eq!(tally.skipped["t a"], "no pictures there");
        assert_eq!(tally.skipped["t b::c"], "no browser");
        assert_eq!(tally.to_string(), "2 passed, 0 failed, 2 skipped");
    }

    #[test]
    fn failures_of_every_program_are_added() {
        let two = "test result: FAILED. 1 passed; 2 failed; 0 ignored\ntest result: ok. 5 passed; 0 failed; 0 ignored\n";
        let mut tally = Tally::of_tests("t", two);
        tally.add(Tally::whole("lint", &Err(anyhow::anyhow!("no"))));
        assert_eq!((tally.passed, tally.failed), (6, 3));
    }
}
