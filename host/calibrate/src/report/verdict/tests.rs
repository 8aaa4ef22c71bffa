use tectum_optics::Medium;

use super::super::sample::{HALF_FIELD_RAD, Sample, sample};
use super::super::{ReportInput, ReportView, judge};
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

fn verdict(sample: &Sample) -> Verdict {
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
        angular_sigma_rad: &|_| None,
        rotation_free_sigma_rad: None,
    };
    judge(&input)
}

fn told(change: impl Fn(&mut Calibration)) -> Verdict {
    let mut sample = sample(&everywhere(), false);
    change(&mut sample.calibration);
    verdict(&sample)
}

fn words(verdict: &Verdict) -> String {
    format!("{}\n{}", verdict.sentence, verdict.advice.join("\n"))
}

#[test]
fn a_full_session_can_be_trusted() {
    let verdict = told(|_| ());
    assert_eq!(verdict.trust, Trust::Whole);
    insta::assert_snapshot!(words(&verdict), @r"
    This calibration can be trusted over all that lens and sensor show: 1540 corners in 33 pictures reach 105 degrees off axis, and pictures held out fit as well as its own.
    Only one picture of a board at 45 to 60 degrees at bottom: take 3 more pictures there.
    ");
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
    let verdict = verdict(&sample(&corner, false));
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
    let three = self::verdict(&sample(&corner[..3], false));
    assert_eq!(three.trust, Trust::No);
    insta::assert_snapshot!(three.sentence, @r"
    Do not use this calibration: 3 pictures cannot tell the lens from the poses.
    ");
}
