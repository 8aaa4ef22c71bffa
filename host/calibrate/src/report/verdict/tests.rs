use tectum_optics::Medium;

use super::super::sample::model;
use super::super::sample::{HALF_FIELD_RAD, Sample, sample};
use super::super::{AngularSigma, ReportInput, ReportView, judge};
use super::{Trust, Verdict};
use crate::Calibration;

/// Boards over the whole field, in 34 pictures.
fn everywhere() -> Vec<[f64; 2]> {
    let ring = |off_axis_deg: f64, count: u8| {
        let turn = std::f64::consts::TAU / f64::from(count);
        (0..count).map(move |i| [off_axis_deg.to_radians(), turn * f64::from(i)])
    };
    let rings = [ring(10.0, 3), ring(45.0, 11), ring(85.0, 20)];
    rings.into_iter().flatten().collect()
}

fn verdict(sample: &Sample, sigma_rad: &AngularSigma) -> Verdict {
    let parts = sample.files.iter().zip(&sample.views);
    let views: Vec<ReportView> = parts
        .map(|(file, view)| ReportView {
            file,
            picture: None,
            view,
        })
        .collect();
    let input = ReportInput {
        eye: "left",
        calibration: &sample.calibration,
        board: sample.board,
        medium: Medium::Air,
        half_field_rad: Some(HALF_FIELD_RAD),
        views: &views,
        angular_sigma_rad: sigma_rad,
        rotation_free_sigma_rad: None,
    };
    judge(&input)
}

/// The same everywhere, rad.
const EVEN_RAD: f64 = 3.1e-4;

fn told(change: impl Fn(&mut Calibration)) -> Verdict {
    let mut sample = sample(&everywhere(), false);
    change(&mut sample.calibration);
    verdict(&sample, &|_| Some(EVEN_RAD))
}

fn words(verdict: &Verdict) -> String {
    format!("{}\n{}", verdict.sentence, verdict.advice.join("\n"))
}

#[test]
fn a_full_session_can_be_trusted() {
    let verdict = told(|_| ());
    assert_eq!(verdict.trust, Trust::Whole);
    insta::assert_snapshot!(words(&verdict), @r"
    This calibration can be trusted over all that lens and sensor show: directions have standard errors of up to 0.018 degrees. 1540 corners in 33 pictures reach 105 degrees off axis, and pictures held out fit as well as its own.
    Only one picture of a board at 45 to 60 degrees at bottom: take 3 more pictures there.
    ");
}

#[test]
fn the_map_of_uncertainty_says_how_far_to_trust() {
    let sample = sample(&everywhere(), false);
    let grows = |px: [f64; 2]| {
        let ray = model().unproject(px).ok()?;
        Some(2e-4 * (1.0 + libm::pow(ray.angle(&nalgebra::Vector3::z()), 5.0)))
    };
    let some = verdict(&sample, &grows);
    // 2e-4 (1 + t^5) rad is 0.1 degrees at 86.
    let Trust::Within(known_rad) = some.trust else {
        panic!("{some:?}");
    };
    assert!((known_rad.to_degrees() - 85.0).abs() < 1e-9, "{known_rad}");
    insta::assert_snapshot!(some.sentence, @r"
    This calibration can be trusted within 85 degrees of the axis, where directions have standard errors of up to 0.088 degrees; farther out they exceed 0.10 degrees, and reach 0.25 degrees at 105 degrees. 1540 corners in 33 pictures reach 105 degrees off axis, and pictures held out fit as well as its own.
    ");
    let worst = some.rings.last().expect("rings to the edge");
    assert!((worst.to_rad - HALF_FIELD_RAD).abs() < 0.02, "{worst:?}");
    let none = verdict(&sample, &|_| Some(4e-3));
    assert_eq!(none.trust, Trust::Care);
    insta::assert_snapshot!(none.sentence, @r"
    Use this calibration with care: directions have a standard error of 0.23 degrees already at the axis.
    ");
    let unknown = verdict(&sample, &|_| None);
    assert_eq!(unknown.trust, Trust::Care);
    assert!(
        unknown.sentence.contains("tell no standard errors"),
        "{}",
        unknown.sentence
    );
}

#[test]
fn an_error_beyond_all_bounds_is_called_unknown() {
    let wild = |px: [f64; 2]| {
        let off = model().unproject(px).ok()?.angle(&nalgebra::Vector3::z());
        Some(if off < 1.5 { EVEN_RAD } else { 7.6 })
    };
    let verdict = verdict(&sample(&everywhere(), false), &wild);
    assert!(
        verdict.sentence.contains("reach an unknown angle at 105"),
        "{}",
        verdict.sentence
    );
}

#[test]
fn overfitting_is_told() {
    let care = told(|calibration| calibration.held_out_rms_px = Some(0.31));
    assert_eq!(care.trust, Trust::Care);
    insta::assert_snapshot!(words(&care), @r"
    Use this calibration with care: pictures held out fit worse than its own, 0.31 px against 0.21 px RMS.
    Only one picture of a board at 45 to 60 degrees at bottom: take 3 more pictures there.
    A lower degree, or more pictures: the lens has learnt its own pictures.
    ");
    let no = told(|calibration| calibration.held_out_rms_px = Some(0.9));
    assert_eq!(no.trust, Trust::No);
    insta::assert_snapshot!(words(&no), @r"
    Do not use this calibration: pictures held out fit 4.2 times worse than its own (0.90 px against 0.21 px RMS).
    Only one picture of a board at 45 to 60 degrees at bottom: take 3 more pictures there.
    A lower degree, or more pictures: the lens has learnt its own pictures.
    ");
}

#[test]
fn what_was_not_checked_or_does_not_fit_is_told() {
    let unchecked = told(|calibration| calibration.held_out_rms_px = None);
    assert_eq!(unchecked.trust, Trust::Care);
    let large = told(|calibration| {
        calibration.rms_px = 1.4;
        calibration.held_out_rms_px = Some(1.5);
    });
    insta::assert_snapshot!(words(&large), @r"
    Use this calibration with care: residuals of 1.40 px RMS are large.
    Only one picture of a board at 45 to 60 degrees at bottom: take 3 more pictures there.
    Is the board flat and stiff, its size stated right, are the pictures sharp?
    ");
    assert_eq!(
        told(|calibration| calibration.rms_px = 40.0).trust,
        Trust::No
    );
    assert_eq!(
        told(|calibration| calibration.rms_px = f64::NAN).trust,
        Trust::No
    );
}

#[test]
fn few_pictures_in_one_corner_are_not_trusted() {
    let corner: Vec<[f64; 2]> = (0..6).map(|i| [1.2, 0.7 + 0.02 * f64::from(i)]).collect();
    let verdict = verdict(&sample(&corner, false), &|_| Some(EVEN_RAD));
    assert_eq!(verdict.trust, Trust::Care);
    insta::assert_snapshot!(words(&verdict), @r"
    Use this calibration with care: boards cover 31 % of the field; it rests on 6 pictures.
    Only 6 pictures with a board: take 14 more.
    No board beyond 95 degrees at right, lower right and bottom: take 8 more pictures there.
    No board beyond 15 degrees at lower left, left, upper left, top and upper right: take 12 more pictures there.
    No board within 15 degrees of the axis: take 4 more pictures there.
    No board at 15 to 45 degrees at right: take 4 more pictures there.
    No board at 15 to 30 degrees at bottom: take 4 more pictures there.
    And 2 more: see the coverage.
    ");
    let three = self::verdict(&sample(&corner[..3], false), &|_| Some(EVEN_RAD));
    assert_eq!(three.trust, Trust::No);
    insta::assert_snapshot!(three.sentence, @r"
    Do not use this calibration: 3 pictures cannot tell the lens from the poses.
    ");
}
