//! `cargo xtask campaign`: what is too long for every run of the tests and rarely breaks.

use anyhow::bail;
use xtask::Outcome;
use xtask::packages::{self, AARCH64};

use crate::{aarch64, cargo, programs, record};

/// A campaign: its name, what it proves, how long it takes on two cores, the folders and files that
/// it proves it of, and what is run.
struct Campaign {
    name: &'static str,
    proves: &'static str,
    minutes: u32,
    part: &'static [&'static str],
    work: Work,
}

#[derive(Clone, Copy)]
enum Work {
    /// What is ignored in these test programs.
    Ignored(&'static [&'static str]),
    /// The tests of an emulated SoC, with all random cases.
    Aarch64,
    /// The boards that the ordinary run leaves out while nothing of theirs changes.
    Boards,
}

const CALIBRATION: &[&str] = &["Cargo.lock", "host/calibrate", "host/optics", "tests/tests"];
const REGISTRATION: &[&str] = &[
    "Cargo.lock",
    "host/stitch",
    "host/optics",
    "host/bake",
    "tests/tests",
];
const CORE: &[&str] = &[
    "Cargo.lock",
    "core",
    "tables",
    "host/bake/src",
    "host/optics/src",
    "tests/exact",
];

const CAMPAIGNS: [Campaign; 11] = [
    Campaign {
        name: "detection",
        proves: "boards of ten real sets are found, whole and covered in 13 ways; no false marker",
        minutes: 14,
        part: &["Cargo.lock", "host/calibrate"],
        work: Work::Ignored(&["host/calibrate/chessboard", "host/calibrate/markers"]),
    },
    Campaign {
        name: "real-calibration",
        proves: "held-out residuals and angles on all real sets (table of docs/calibration.md), real stereo pose",
        minutes: 5,
        part: CALIBRATION,
        work: Work::Ignored(&[
            "tests/calibration",
            "tests/calibration_rigs",
            "tests/real_directions",
        ]),
    },
    Campaign {
        name: "choice",
        proves: "the lens family chosen on random subsets of real sets, by what it does on the rest",
        minutes: 10,
        part: CALIBRATION,
        work: Work::Ignored(&["tests/calibration_campaign"]),
    },
    Campaign {
        name: "calibration",
        proves: "stated errors of directions and of two eyes' pose cover the truth over simulated sessions",
        minutes: 15,
        part: CALIBRATION,
        work: Work::Ignored(&["tests/calibration_errors"]),
    },
    Campaign {
        name: "truth",
        proves: "calibration to look-up beside exact truth, in air and in water; stated errors cover it",
        minutes: 4,
        part: &[
            "Cargo.lock",
            "core",
            "tables",
            "host/bake",
            "host/calibrate",
            "host/optics",
            "tests/tests",
        ],
        work: Work::Ignored(&["tests/calibration_truth", "host/calibrate/lib"]),
    },
    Campaign {
        name: "chain",
        proves: "the program's own commands from printed boards to directions, on a mount 4 degrees and 5 mm off",
        minutes: 4,
        part: &["Cargo.lock", "core", "tables", "host"],
        work: Work::Ignored(&["host/cli/chain"]),
    },
    Campaign {
        name: "registration",
        proves: "eyes placed by real boards and natural features beside published poses, and off their mounts; seams",
        minutes: 16,
        part: REGISTRATION,
        work: Work::Ignored(&[
            "host/stitch/lib",
            "host/stitch/boards",
            "host/stitch/colour_and_alignment",
            "host/stitch/natural",
            "host/cli/cli",
        ]),
    },
    Campaign {
        name: "rigs",
        proves: "every rig and every published calibration, baked large and compared byte for byte",
        minutes: 2,
        part: CORE,
        work: Work::Ignored(&["tests/real_rigs", "host/bake/scales"]),
    },
    Campaign {
        name: "exact",
        proves: "the core equals its reference on 100,000 random tables",
        minutes: 3,
        part: CORE,
        work: Work::Ignored(&["tests/exact/differential"]),
    },
    Campaign {
        name: AARCH64_NAME,
        proves: "tables, core and bake are the same to the byte on emulated aarch64, all cases",
        minutes: 8,
        part: CORE,
        work: Work::Aarch64,
    },
    Campaign {
        name: BOARDS_NAME,
        proves: "the core on all emulated boards: bytes, counts, stack, size, no panic path",
        minutes: 4,
        part: &[
            "core",
            "tables",
            "firmware-sim",
            "xtask/checks/src/firmware",
        ],
        work: Work::Boards,
    },
];
const AARCH64_NAME: &str = "aarch64";
const BOARDS_NAME: &str = "boards";

/// Whether nothing has changed that campaign `aarch64` proves.
pub fn aarch64_is_current() -> bool {
    is_current(AARCH64_NAME)
}

/// Whether nothing has changed that campaign `boards` proves.
pub fn boards_are_current() -> bool {
    is_current(BOARDS_NAME)
}

fn is_current(name: &str) -> bool {
    let campaign = CAMPAIGNS.iter().find(|c| c.name == name);
    campaign.is_some_and(|c| record::is_current(name, c.part))
}

/// Names of the campaigns whose part has changed since they passed.
pub fn due() -> Vec<&'static str> {
    let due = CAMPAIGNS
        .iter()
        .filter(|c| !record::is_current(c.name, c.part));
    due.map(|c| c.name).collect()
}

/// Lists campaigns or runs one.
pub fn run(list: bool, name: Option<&str>) -> anyhow::Result<Outcome> {
    if list {
        let due = due();
        for Campaign {
            name,
            proves,
            minutes,
            ..
        } in &CAMPAIGNS
        {
            let state = if due.contains(name) { "due" } else { "passed" };
            println!("{name:<16} {minutes:>3} min  {state:<6}  {proves}");
        }
        println!("\ndue: files of its part have changed since it passed (xtask/campaigns.txt)");
        return Ok(Outcome::Passed);
    }
    let Some(campaign) = CAMPAIGNS.iter().find(|c| Some(c.name) == name) else {
        bail!("which campaign? `cargo xtask campaign --list` names them");
    };
    println!(
        "{}: {}, about {} minutes",
        campaign.name, campaign.proves, campaign.minutes
    );
    // Before it begins: what is edited while it runs has not passed.
    let hash = record::hash(campaign.part)?;
    let outcome = match campaign.work {
        Work::Ignored(tests) => ignored(tests)?,
        Work::Aarch64 if !packages::are_there(AARCH64) => {
            Outcome::Skipped(packages::advice(AARCH64))
        }
        Work::Aarch64 => {
            cargo::run(&mut aarch64::campaign())?;
            Outcome::Passed
        }
        Work::Boards => cargo::check("firmware", &["test".into()])?,
    };
    // What did not run whole has not passed.
    if outcome != Outcome::Passed {
        return Ok(outcome);
    }
    record::passed(campaign.name, hash)?;
    println!("noted in xtask/campaigns.txt: commit it with the change");
    Ok(Outcome::Passed)
}

/// Runs the ignored tests of these test programs. Skipped where one of them was.
fn ignored(tests: &[&str]) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::Passed;
    for program in programs::build()? {
        if !tests.contains(&&*program.name) {
            continue;
        }
        let mut command = program.command();
        command.args(["--ignored", "--nocapture"]);
        if let skipped @ Outcome::Skipped(_) = cargo::run_tests(&mut command)? {
            outcome = skipped;
        }
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_exist() {
        for part in CAMPAIGNS.iter().flat_map(|c| c.part) {
            assert!(xtask::repository().join(part).exists(), "{part}");
        }
    }
}
