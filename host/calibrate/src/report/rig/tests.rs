use nalgebra::Vector3;
use tectum_optics::{Medium, Pose, Side};

use super::*;
use crate::report::sample::{model, sample};
use crate::stereo::PairLeftOut;
use crate::{BoardPose, report};

/// Eyes of the paper's mount, 60 mm apart, and their boards, of which the right eye knows as the left
/// one does.
#[test]
fn the_page_shows_pairs_mount_and_both_eyes() {
    let session = sample(&[[0.1, 0.0], [0.5, 1.0], [0.6, 3.0], [0.4, 5.0]], false);
    let (psi, tau) = (25.7f64.to_radians(), 29.15f64.to_radians());
    let [left, right] = [Side::Left, Side::Right].map(|side| Pose::mount_rotation(side, psi, tau));
    let rotation = left.inverse() * right;
    let position_mm = left.inverse() * Vector3::new(0.0, -60.0, 0.0);
    let mut beside = session.calibration.clone();
    for view in &mut beside.views {
        view.pose = view.pose.map(|pose| BoardPose {
            rotation: rotation.inverse() * pose.rotation,
            position_mm: rotation.inverse() * (pose.position_mm - position_mm),
        });
    }
    let both = StereoCalibration {
        rotation,
        rotation_standard_error_rad: Vector3::repeat(1e-4),
        position_mm,
        position_standard_error_mm: Vector3::repeat(0.03),
        left: model(),
        right: model(),
        parameters: [Vec::new(), Vec::new()],
        pairs_rms_px: vec![Some(0.21), None, Some(0.2), None],
        left_out: vec![PairLeftOut {
            pair: 1,
            rms_px: None,
            alone_rms_px: 0.19,
        }],
        alone_rms_px: 0.2,
        rms_px: 0.21,
    };
    let section = report::numbered(
        "<a href=\"#coverage\">x</a><p id=\"coverage\">y</p>",
        "left",
    );
    assert_eq!(
        section,
        "<a href=\"#left-coverage\">x</a><p id=\"left-coverage\">y</p>"
    );
    let names = ["a<1>.png", "b.png", "c.png"].map(String::from);
    let input = RigReportInput {
        rig: "fish & co",
        both: &both,
        eyes: [&session.calibration, &beside],
        pairs: &names,
        board: session.board,
        medium: Medium::Water,
        trust: [Trust::Whole, Trust::Whole],
        sections: [&section, ""],
    };
    let page = html(&input);
    // One pair of three is left out.
    assert!(page.contains("verdict care") && page.contains("1 of 3 pairs were left out"));
    let all = StereoCalibration {
        left_out: Vec::new(),
        ..both.clone()
    };
    for (trust, class) in [
        (Trust::Whole, "verdict good"),
        (Trust::Care, "verdict care"),
        (Trust::No, "verdict bad"),
    ] {
        let page = html(&RigReportInput {
            both: &all,
            trust: [Trust::Whole, trust],
            ..input
        });
        assert!(page.contains(class), "{class}");
        assert_eq!(
            page.contains("its own report says why"),
            trust != Trust::Whole
        );
    }
    for part in [
        "Rig fish &amp; co",
        "2 <small>of 3</small>",
        "60.00 <small>± 0.03 mm</small>",
        "25.700°",
        "29.150°",
        "beyond a fit",
        "b.png",
        "id=\"left-coverage\"",
        "in water",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for bad in ["NaN", "inf", "<script", "http"] {
        assert!(!page.contains(bad), "{bad}");
    }
    // Each board's outline as both eyes see it, on four sides; that of the pair left out is red.
    let boards = session.calibration.views.len();
    assert_eq!(
        page.matches("class=\"blue faint\"").count(),
        4 * (boards - 1)
    );
    assert_eq!(
        page.matches("class=\"green faint\"").count(),
        4 * (boards - 1)
    );
    assert_eq!(page.matches("class=\"red\"").count(), 4 * 2);
    // Where both see it the outlines are the same, to the decimals drawn.
    let path = |class: &str| {
        let at = page.find(&format!("class=\"{class}\"")).unwrap();
        page[at..].split('"').nth(3).unwrap().to_owned()
    };
    assert_eq!(path("blue faint"), path("green faint"));
}
