//! How far calibrations of real sets are trusted, as the report has it.

use rayon::prelude::*;
use tectum_calibrate::report::{ReportInput, ReportView, judge, verdict::Verdict};
use tectum_calibrate::solve::{AngularUncertainty, calibrate};
use tectum_optics::Medium;

use crate::sets::{Set, real};

fn verdict(set: &Set) -> Verdict {
    let calibration = calibrate(&set.problem, &set.options).expect("a calibration");
    let views = set.problem.views.iter().map(|view| ReportView {
        file: set.name,
        picture: None,
        view,
    });
    let views: Vec<ReportView<'_>> = views.collect();
    let uncertainty = AngularUncertainty::new(&calibration).expect("a model");
    judge(&ReportInput {
        eye: set.name,
        calibration: &calibration,
        board: set.problem.board,
        medium: Medium::Air,
        half_field_rad: None,
        views: &views,
        angular_sigma_rad: &|pixel| uncertainty.sigma_rad(pixel),
        rotation_free_sigma_rad: Some(&|pixel| uncertainty.rotation_free_sigma_rad(pixel)),
    })
}

/// Greatest standard error of the ring at an angle off axis, degrees; none beyond the last.
fn at_deg(verdict: &Verdict, off_axis_deg: f64) -> Option<f64> {
    let ring = verdict
        .rings
        .iter()
        .find(|ring| (ring.from_rad..=ring.to_rad).contains(&off_axis_deg.to_radians()))?;
    Some(ring.worst_rad.to_degrees())
}

/// Prints the sets' stated errors and verdicts; the angles off axis up to which each is trusted, degrees.
fn known_deg(sets: &[Set]) -> Vec<(&'static str, f64)> {
    println!("set | stated error, degrees, at the axis | 30 | 60 | 85 degrees off axis | verdict");
    let verdicts: Vec<Verdict> = sets.par_iter().map(verdict).collect();
    let known = sets.iter().zip(verdicts).map(|(set, verdict)| {
        let stated = [1.0, 31.0, 61.0, 86.0]
            .map(|deg| at_deg(&verdict, deg).map_or("-".into(), |stated| format!("{stated:.3}")));
        println!(
            "{} | {} | {}",
            set.name,
            stated.join(" | "),
            verdict.sentence
        );
        let known = tectum_calibrate::report::precision::known_rad(&verdict.rings);
        (set.name, known.unwrap_or_default().to_degrees())
    });
    known.collect()
}

/// Angles between corners that took no part are right to 0.074 degrees RMS there, out to the farthest
/// corner at 84 degrees, in lenses from half of its pictures (`tests/real_directions.rs`).
#[test]
fn a_real_set_is_trusted_as_far_as_its_angles_prove_it() {
    for (name, known) in known_deg(&real("ocam-fisheye1")) {
        assert!(known >= 80.0, "{name}: {known}");
    }
}

#[test]
#[ignore = "campaign calibration: 11 calibrations"]
fn real_sets_are_known_at_least_at_the_axis() {
    let sets = real("");
    if sets.is_empty() {
        return;
    }
    let known = known_deg(&sets);
    // The mirror of one hides its axis.
    let seen = known
        .into_iter()
        .filter(|(name, _)| !name.contains("kaidan"));
    for (name, known) in seen {
        assert!(known > 0.0, "{name}");
    }
}
