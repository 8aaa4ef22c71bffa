use image::{GrayImage, Luma};
use nalgebra::{DMatrix, Vector3};
use tectum_optics::Medium;

use super::sample::{HALF_FIELD_RAD, Sample, model, sample};
use super::{ReportInput, ReportView, html};
use crate::{BoardPose, Rejection, View, ViewFit};

/// Boards all round out to 90 degrees, but none at the lower left beyond 55.
fn directions() -> Vec<[f64; 2]> {
    let mut directions = vec![[0.05, 0.0], [0.15, 2.0], [0.2, 4.0]];
    for step in 0..10 {
        directions.push([40f64.to_radians(), f64::from(step) * 0.628]);
    }
    for step in 0..14 {
        let azimuth = f64::from(step) * std::f64::consts::TAU / 14.0;
        let lower_left = (100.0..170.0).contains(&azimuth.to_degrees());
        let off_axis: f64 = if lower_left { 30.0 } else { 84.0 };
        directions.push([off_axis.to_radians(), azimuth]);
    }
    directions
}

/// Grows towards the rim as the standard error of a fit does.
fn sigma(px: [f64; 2]) -> Option<f64> {
    let ray = model().unproject(px).ok()?;
    let theta = ray.angle(&Vector3::z());
    let azimuth = libm::atan2(ray.y, ray.x);
    let uneven = 1.0 + 0.4 * libm::cos(azimuth - 2.3) * theta;
    Some((2e-3 + 6e-3 * theta.powi(2) + 4e-3 * theta.powi(6) / 20.0).to_radians() * uneven)
}

fn page_with(sample: &Sample, half_field_rad: Option<f64>, kept: bool) -> String {
    let parts = sample.files.iter().zip(&sample.pictures).zip(&sample.views);
    let views: Vec<ReportView> = parts
        .map(|((file, picture), view)| ReportView {
            file,
            picture: kept.then_some(picture),
            view,
        })
        .collect();
    html(&ReportInput {
        eye: "left",
        calibration: &sample.calibration,
        board: sample.board,
        medium: Medium::Water,
        half_field_rad,
        views: &views,
        angular_sigma_rad: &sigma,
        rotation_free_sigma_rad: kept.then_some(&|px| Some(0.4 * sigma(px)?)),
    })
}

fn page(sample: &Sample) -> String {
    page_with(sample, Some(HALF_FIELD_RAD), true)
}

/// A page is whole and holds nothing that is no number.
fn check(page: &str) {
    assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    let plain = page
        .split("base64,")
        .map(|part| part.split_once('"').map_or(part, |p| p.1));
    for part in plain {
        for bad in [
            "NaN", "inf\"", "inf ", "-inf", "http://", "https://", "<script", "url(http",
        ] {
            assert!(!part.contains(bad), "{bad} in {:.300}", part);
        }
    }
    for element in [
        "svg", "g", "figure", "section", "table", "tr", "div", "ul", "li",
    ] {
        let open = page.matches(&format!("<{element} ")).count()
            + page.matches(&format!("<{element}>")).count();
        assert_eq!(
            open,
            page.matches(&format!("</{element}>")).count(),
            "{element}"
        );
    }
}

#[test]
fn a_session_becomes_a_page() {
    let page = page_with(&sample(&directions(), true), None, true);
    if let Some(path) = std::env::var_os("TECTUM_REPORT") {
        std::fs::write(path, &page).unwrap();
    }
    check(&page);
    for words in [
        "left-007.png",
        "no flat board fits: 7.41 px RMS",
        "no board beyond 65 degrees at lower left: take 4 more pictures there",
        "folds back at 97 degrees",
        "polynomial[4]",
        "The lowest held-out figure is that of ocam, degree 5, 0.2240 px.",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(page.contains("<tr class=\"chosen\"><td>ocam, degree 5"));
    // 27 pictures of at most 420 px: 40 of the largest must stay below 3 MB.
    assert!(page.len() < 27 * 3_000_000 / 40, "{}", page.len());
}

#[test]
fn hostile_names_are_inert() {
    let mut sample = sample(&directions()[..4], false);
    sample.files[0] = "\"><script>alert(1)</script>.png".into();
    sample.calibration.scores[0].name = "<b onload='x'>".into();
    sample.calibration.parameters[0].name = "<i>&".into();
    let page = page(&sample);
    check(&page);
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;.png"));
    assert!(!page.contains("<b onload") && !page.contains("<i>&<"));
}

#[test]
fn no_view_makes_a_page_that_says_so() {
    let page = page(&sample(&[], false));
    check(&page);
    assert!(page.contains("Do not use this calibration: no picture took part."));
}

#[test]
fn odd_views_make_a_page() {
    let mut odd = sample(&directions()[..6], false);
    odd.views[0].corners.truncate(1);
    odd.views[1] = View::default();
    odd.calibration.views[2].corners[0].residual_px = [f64::NAN, 1.0];
    odd.calibration.views[2].corners[1].residual_px = [f64::INFINITY, 1e300];
    odd.calibration.views[2].rms_px = f64::NAN;
    odd.views[3].corners[0].position_px = [f64::NAN, -1e300];
    odd.calibration.views[4] = ViewFit {
        pose: None,
        corners: Vec::new(),
        rms_px: f64::NAN,
        rejection: Some(Rejection::TooFewCorners { corners: 3 }),
    };
    if let Some(BoardPose { position_mm, .. }) = &mut odd.calibration.views[5].pose {
        position_mm.x = f64::NAN;
    }
    odd.pictures[0] = GrayImage::from_pixel(1, 1, Luma([9]));
    odd.pictures[2] = GrayImage::from_pixel(3, 2000, Luma([9]));
    odd.calibration.views.pop();
    check(&page(&odd));
    check(&page_with(&odd, None, true));
    check(&page_with(&odd, Some(f64::NAN), false));
}

#[test]
fn odd_figures_make_a_page() {
    let mut odd = sample(&directions()[..6], false);
    odd.calibration.size_px = [0, 0];
    odd.calibration.rms_px = f64::NAN;
    odd.calibration.held_out_rms_px = Some(f64::INFINITY);
    odd.calibration.field_rad = f64::NAN;
    odd.calibration.parameters[0].value = f64::NAN;
    odd.calibration.parameters[1].standard_error = f64::INFINITY;
    odd.calibration.scores[0].rms_px = f64::NAN;
    odd.calibration.covariance = DMatrix::zeros(0, 0);
    check(&page(&odd));
    odd.calibration.size_px = [u32::MAX, 1];
    odd.calibration.scores.clear();
    odd.calibration.parameters.clear();
    check(&page(&odd));
}
