//! `cargo xtask campaign`: what is too long for every run of the tests and rarely breaks.

use anyhow::bail;
use xtask::Outcome;

use crate::cargo::{self, cargo, everything};

/// A campaign: its name, what it proves, how long it takes on two cores, and the test programs of
/// which it runs what is ignored.
struct Campaign {
    name: &'static str,
    proves: &'static str,
    minutes: u32,
    tests: &'static [&'static str],
}

const CAMPAIGNS: [Campaign; 5] = [
    Campaign {
        name: "detection",
        proves: "boards of ten real sets are found, whole and covered in 13 ways",
        minutes: 5,
        tests: &["chessboard"],
    },
    Campaign {
        name: "real-calibration",
        proves: "held-out residuals and angles on all real sets (README's table)",
        minutes: 5,
        tests: &["calibration", "real_directions"],
    },
    Campaign {
        name: "truth",
        proves: "calibration to look-up beside exact truth, in air and in water",
        minutes: 3,
        tests: &["calibration_truth"],
    },
    Campaign {
        name: "registration",
        proves: "eyes placed by natural features of real pictures, beside published poses",
        minutes: 10,
        tests: &["natural"],
    },
    Campaign {
        name: "exact",
        proves: "the core equals its reference on 100,000 random tables",
        minutes: 3,
        tests: &["differential"],
    },
];

/// Lists campaigns or runs one.
pub fn run(list: bool, name: Option<&str>) -> anyhow::Result<Outcome> {
    if list {
        for campaign in &CAMPAIGNS {
            println!(
                "{:<16} {:>3} min  {}",
                campaign.name, campaign.minutes, campaign.proves
            );
        }
        return Ok(Outcome::Passed);
    }
    let Some(campaign) = CAMPAIGNS.iter().find(|c| Some(c.name) == name) else {
        bail!("which campaign? `cargo xtask campaign --list` names them");
    };
    println!(
        "{}: {}, about {} minutes",
        campaign.name, campaign.proves, campaign.minutes
    );
    for test in campaign.tests {
        let mut command = cargo(&["test", "--test", test]);
        command
            .args(everything())
            .args(["--", "--ignored", "--nocapture"]);
        cargo::run(&mut command)?;
    }
    Ok(Outcome::Passed)
}
