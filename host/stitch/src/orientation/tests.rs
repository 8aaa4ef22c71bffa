//! Boards drawn by geometry alone: what is put in must come out.

use nalgebra::{Rotation3, Vector3};
use tectum_calibrate::{BoardSize, Corner, View};
use tectum_optics::design::OrientationBoard;
use tectum_optics::{OutputMap, Pose, Projection, Rig, Side, rotation_vector, vector_of_rotation};

use super::*;
use crate::epipolar::rotation_between;

const RIG: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
    [mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n\
    [left]\nsize_px = [960, 960]\nfield_deg = 160.0\n\
    lens = { model = 'equidistant', focal_px_per_rad = 260.0, centre_px = [479.5, 479.5] }\n\
    [right]\nsize_px = [960, 960]\nfield_deg = 160.0\n\
    lens = { model = 'equidistant', focal_px_per_rad = 260.0, centre_px = [479.5, 479.5] }\n";

fn rig() -> Rig {
    Rig::from_toml(RIG, "rig.toml").unwrap()
}

fn map() -> OutputMap {
    Projection::Equirect.output_map([1280, 640]).unwrap()
}

/// The paper's board: rows -2 to 5, columns -2 to 8.
fn placement() -> Placement {
    let board = BoardSize {
        columns: 11,
        rows: 8,
    };
    Placement::new(board, [2, 2], OrientationBoard::new(0.16, 0.035).unwrap()).unwrap()
}

/// What a picture of `rig` shows of the board if its eyes are truly turned by `turn` in the body, as
/// a detector labels it, from the left or from below.
fn shot(side: Side, turn: &Rotation3<f64>, upside_down: bool) -> Shot {
    shot_of(side, turn, TurnAbout::Body, upside_down)
}

/// The same, with the eyes turned as one piece or each in its place.
fn shot_of(side: Side, turn: &Rotation3<f64>, about: TurnAbout, upside_down: bool) -> Shot {
    let (rig, map, placement) = (rig(), map(), placement());
    let eye = match side {
        Side::Left => rig.left.as_ref(),
        Side::Right => rig.right.as_ref(),
    };
    let eye = eye.unwrap();
    let truly = Pose {
        rotation: turn * eye.pose.rotation,
        position_m: match about {
            TurnAbout::Body => turn * eye.pose.position_m,
            TurnAbout::Eyes => eye.pose.position_m,
        },
    };
    let BoardSize { columns, rows } = placement.board();
    let mut corners = Vec::new();
    for column in 0..columns {
        for row in 0..rows {
            let point = placement.corner_m(side, placement.ij([column, row]));
            let ray = truly.rotation.inverse() * (point - truly.position_m);
            let pixel = eye.eye.project(&ray).unwrap();
            let shown = eye.direction_of(pixel, rig.stitch_distance_m).unwrap();
            let to_right = match side {
                Side::Left => column,
                Side::Right => columns - 1 - column,
            };
            let [mut i, mut j] = [to_right, rows - 1 - row];
            if upside_down {
                [i, j] = [columns - 1 - i, rows - 1 - j];
            }
            let position_px = map.pixel(&shown).unwrap();
            corners.push(Corner {
                i,
                j,
                position_px,
                sigma_px: 0.05,
            });
        }
    }
    Shot {
        name: format!("{side:?}"),
        side,
        view: View { corners },
    }
}

fn aligned(shots: &[Shot]) -> Result<Alignment, OrientationError> {
    let eye = |[x, _]: [f64; 2]| Some(usize::from(x > 639.5));
    align(&rig(), &map(), eye, &placement(), shots)
}

#[test]
fn a_true_rig_is_found_true() {
    let still = Rotation3::identity();
    for upside_down in [false, true] {
        let shots = [Side::Left, Side::Right].map(|side| shot(side, &still, upside_down));
        let found = aligned(&shots).unwrap();
        assert_eq!(found.corners.len(), 2 * 88);
        // Rounding through projection and its inverse.
        assert!(found.rms_rad < 1e-9, "{}", found.rms_rad);
        let first = &found.corners[0];
        let board = *placement().geometry_m();
        let (yaw, pitch) = tectum_optics::convention::yaw_pitch(&first.truth);
        let [i, j] = first.ij;
        assert!((yaw - board.yaw_rad(Side::Left, j)).abs() < 1e-12);
        assert!((pitch - board.pitch_rad(i, j, Default::default())).abs() < 1e-12);
    }
}

#[test]
fn a_turned_head_is_found_and_put_right() {
    let turn = rotation_vector(&Vector3::new(0.02, -0.03, 0.015));
    let shots = [Side::Left, Side::Right].map(|side| shot(side, &turn, false));
    let found = aligned(&shots).unwrap();
    assert!(found.rms_rad > 0.02);
    // The stitched picture is exact for one range only, so the turn of nearer points is not a turn of
    // their directions to the last digit.
    // Not nalgebra's `angle_to`: the arc cosine of a trace that rounding puts above 3 is no number.
    let off_rad = vector_of_rotation(&(turn.inverse() * found.turned.turn)).norm();
    assert!(off_rad < 1e-4, "{off_rad}");
    assert!(found.turned.rms_rad < 2e-4, "{}", found.turned.rms_rad);
    let put_right = corrected(&rig(), &found, &Correction::Turn, [256, 128]).unwrap();
    for (eye, was) in [
        (&put_right.rig.left, &rig().left),
        (&put_right.rig.right, &rig().right),
    ] {
        let [now, was] = [eye, was].map(|eye| eye.as_ref().unwrap().pose.rotation);
        assert!(vector_of_rotation(&((turn * was).inverse() * now)).norm() < 1e-8);
    }
    assert!(put_right.seam_png.is_none() && put_right.warp.is_none());
}

/// 2.0, 1.5 and 1.66 degrees, in place and with the body: to within 0.02 degrees, told apart.
#[test]
fn eyes_turned_in_their_places_are_told_from_a_turned_body() {
    for turn_deg in [
        [0.0, 0.0, 2.0],
        [1.5, 0.0, 0.0],
        [0.0, 1.66, 0.0],
        [1.0, -1.5, 2.0],
    ] {
        let turn = rotation_vector(&(Vector3::from(turn_deg) * std::f64::consts::PI / 180.0));
        for about in [TurnAbout::Body, TurnAbout::Eyes] {
            let shots = [Side::Left, Side::Right].map(|side| shot_of(side, &turn, about, false));
            let found = aligned(&shots).unwrap();
            let off_deg = rotation_between(&turn, &found.turned.turn).to_degrees();
            println!(
                "{turn_deg:?} {about:?}: {:?}, {off_deg:.5} degrees off",
                found.turned.about
            );
            assert!(off_deg < 0.02, "{turn_deg:?} {about:?}: {off_deg}");
            assert!(!found.is_undecided());
            let eye_m = rig().left.unwrap().pose.position_m;
            if (turn * eye_m - eye_m).norm() < 1e-9 {
                // Eyes on the axis of the turn stay where they are: both kinds are the same.
                assert!(rotation_between(&found.turned.turn, &found.other.turn) < 1e-9);
                continue;
            }
            assert_eq!(found.turned.about, about, "{turn_deg:?}");
            // The turn of the other kind would have been wrong by more than its standard error.
            let other_deg = rotation_between(&turn, &found.other.turn).to_degrees();
            assert!(other_deg > 0.05, "{other_deg}");
            let put_right = corrected(&rig(), &found, &Correction::Turn, [64, 32]).unwrap();
            let was = rig().left.unwrap().pose.position_m;
            let now = put_right.rig.left.unwrap().pose.position_m;
            assert_eq!((now - was).norm() < 1e-9, about == TurnAbout::Eyes);
        }
    }
}

#[test]
fn a_board_put_down_askew_is_told_apart_from_a_wrong_picture() {
    let placement = placement();
    let askew = rotation_vector(&Vector3::new(0.0, 0.0, 0.05));
    let mut left = shot(Side::Left, &Rotation3::identity(), false);
    let origin = placement.corner_m(Side::Left, [0, 0]);
    let moved = Vector3::new(0.01, 0.02, -0.005);
    let (rig, map) = (rig(), map());
    let eye = rig.left.as_ref().unwrap();
    for corner in &mut left.view.corners {
        let ij = placement.ij([corner.i, 7 - corner.j]);
        let point = askew * (placement.corner_m(Side::Left, ij) - origin) + origin + moved;
        let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
        let pixel = eye.eye.project(&ray).unwrap();
        let shown = eye.direction_of(pixel, rig.stitch_distance_m).unwrap();
        corner.position_px = map.pixel(&shown).unwrap();
    }
    let found = aligned(&[left]).unwrap();
    let board = &found.boards[0];
    // The solver ends at rounding of its differences.
    assert!((board.origin_m - origin - moved).norm() < 1e-7, "{board:?}");
    assert!((board.turned_rad - Vector3::new(0.0, 0.0, 0.05)).norm() < 1e-6);
    assert!(board.rms_rad < 1e-7 && found.rms_rad > 0.03);
}

#[test]
fn a_nominal_lens_gets_a_scale_of_its_own() {
    // The picture is bent as by a lens that magnifies a little more than its data sheet says.
    let still = Rotation3::identity();
    let wrong = |shown: &Vector3<f64>, axis: Vector3<f64>| {
        let away = shown - axis * axis.dot(shown);
        (shown + away * 0.03 * away.norm_squared()).normalize()
    };
    let axis = |eye: &Option<tectum_optics::RigEye>| eye.as_ref().unwrap().pose.optical_axis();
    let axes = [axis(&rig().left), axis(&rig().right)];
    let mut shots = [Side::Left, Side::Right].map(|side| shot(side, &still, false));
    for (shot, axis) in shots.iter_mut().zip(axes) {
        for corner in &mut shot.view.corners {
            let [x, y] = corner.position_px;
            let bent = wrong(&map().ray(x, y).unwrap(), axis);
            corner.position_px = map().pixel(&bent).unwrap();
        }
    }
    let found = aligned(&shots).unwrap();
    assert!(found.turned.rms_rad > 3e-3, "{}", found.turned.rms_rad);
    let scale = found.own_scale().unwrap();
    // A tenth of what the turn leaves, at corners that were left out.
    assert!(
        scale.left_out_rms_rad < found.turned.rms_rad / 10.0,
        "{scale:?}"
    );
    for corner in &found.corners {
        let off =
            tectum_optics::convention::angle_between(&scale.shown(&corner.expected), &corner.shown);
        assert!(off < 5e-4, "{off}");
    }
    // Far from the boards, straight behind, only the turn is left.
    let far = Vector3::new(-1.0, 0.0, 0.0);
    assert!((scale.shown(&far) - found.turned.turn.inverse() * far).norm() < 1e-12);
    let put_right = corrected(&rig(), &found, &Correction::Scale(scale.clone()), [64, 32]);
    let warp = put_right.unwrap().warp.unwrap().map().unwrap();
    for corner in &found.corners {
        let eye = usize::from(corner.side == Side::Right);
        let bent = warp.bent(eye, &corner.expected);
        let wanted = found.turned.turn * scale.shown(&corner.expected);
        // The raster's spline smooths a bend of a degree by 0.01 degrees.
        let off = tectum_optics::convention::angle_between(&bent, &wanted);
        assert!(off < 2e-4, "{off}");
    }
}

#[test]
fn boards_that_cannot_be_are_refused() {
    let still = Rotation3::identity();
    let good = || [Side::Left, Side::Right].map(|side| shot(side, &still, false));
    // The right board seen one column farther ahead than it says.
    let mut ahead = good();
    let rig = rig();
    let eye = rig.right.as_ref().unwrap();
    for corner in &mut ahead[1].view.corners {
        let ij = placement().ij([10 - corner.i, 7 - corner.j]);
        let point = placement().corner_m(Side::Right, [ij[0], ij[1] + 2]);
        let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
        let pixel = eye.eye.project(&ray).unwrap();
        let shown = eye.direction_of(pixel, 2.0).unwrap();
        corner.position_px = map().pixel(&shown).unwrap();
    }
    let error = aligned(&ahead).unwrap_err();
    assert!(
        matches!(error, OrientationError::Contradicts { .. }),
        "{error}"
    );

    let mut swapped = good();
    swapped[0].side = Side::Right;
    let error = aligned(&swapped).unwrap_err();
    assert!(
        matches!(error, OrientationError::OtherSide { .. }),
        "{error}"
    );

    let mut partly = good();
    partly[1].view.corners.retain(|corner| corner.i < 9);
    let error = aligned(&partly).unwrap_err();
    assert!(error.to_string().contains("only 9x8"), "{error}");

    let mut mirrored = good();
    for corner in &mut mirrored[0].view.corners {
        corner.j = 7 - corner.j;
    }
    let error = aligned(&mirrored).unwrap_err();
    assert!(matches!(error, OrientationError::Lying { .. }), "{error}");

    assert_eq!(aligned(&[]).unwrap_err(), OrientationError::NoShots);
    let board = placement().board();
    let geometry = OrientationBoard::new(0.16, 0.035).unwrap();
    let error = Placement::new(board, [11, 0], geometry).unwrap_err();
    assert!(error.to_string().contains("11x8"), "{error}");
    let near = OrientationBoard::new(0.02, 0.0005).unwrap();
    let near = Placement::new(board, [2, 2], near).unwrap();
    let eye = |_| Some(0);
    let error = align(&rig, &map(), eye, &near, &good()).unwrap_err();
    assert_eq!(error, OrientationError::TooNear);
}
