use super::*;

#[test]
fn a_page_shows_what_was_done_and_no_more() {
    let picture = RgbImage::from_pixel(40, 30, image::Rgb([90, 120, 150]));
    let pair = |x: f64| Correspondence {
        shot: 0,
        left_px: [x, 10.0],
        right_px: [40.0 - x, 12.0],
    };
    let matches = [(pair(5.0), Some(0.002)), (pair(9.0), None)];
    let shots = [Shot {
        name: "<shot>",
        pictures: Some([&picture, &picture]),
        matches: &matches,
    }];
    let figures = [Figure {
        value: "1 of 2".into(),
        name: "matches",
        note: "used".into(),
    }];
    let nothing = ReportInput {
        rig: "fish & co",
        matcher: "boards",
        figures: &figures,
        verdict: "Turned by 1 degree.",
        warnings: &[],
        shots: &[],
        parallax: &[],
        curves: None,
        energy: None,
        similarity: [&[], &[]],
        stitched: None,
    };
    let page = html(&nothing);
    assert!(page.contains("fish &amp; co") && page.contains("1 of 2"));
    assert!(!page.contains("<h2"), "no section without content");

    let straight = [std::array::from_fn(|v| v as u8); 3];
    let warnings = ["The board was far.".to_owned()];
    let page = html(&ReportInput {
        warnings: &warnings,
        shots: &shots,
        parallax: &[[0.5, 0.02], [2.0, 0.0], [f64::INFINITY, 0.01]],
        curves: Some(&[straight; 2]),
        energy: Some(&picture),
        similarity: [&[[-90.0, 0.4], [90.0, f64::NAN]], &[[0.0, 0.8]]],
        stitched: Some(&picture),
        ..nothing
    });
    for part in [
        "id=\"matches\"",
        "id=\"colour\"",
        "id=\"seam\"",
        "&lt;shot&gt;",
        "1 of 2 matches used",
        "The board was far.",
        "Turned by 1 degree.",
        "<td>infinity</td>",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        !page.contains("NaN") && !page.contains("inf\""),
        "figures are finite"
    );
}
