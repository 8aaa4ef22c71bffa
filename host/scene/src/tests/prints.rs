//! Boards and markers: do pictures show what the truth says?

use super::*;
use crate::camera::equidistant;

/// A pool with one board and one marker, seen straight on by a body at the origin.
fn printed() -> SceneDescription {
    let mut description = bare(Medium::Air);
    let pose = PanelPose {
        position_m: [1.5, 0.2, -0.1],
        yaw_deg: 172.0,
        pitch_deg: 5.0,
        roll_deg: 12.0,
    };
    description.boards = vec![Board {
        columns: 5,
        rows: 4,
        square_mm: 150.0,
        pose,
    }];
    let pose = PanelPose {
        position_m: [-1.2, 0.3, 0.2],
        yaw_deg: -14.0,
        pitch_deg: 8.0,
        roll_deg: -9.0,
    };
    let dictionary = "DICT_4X4_50".to_string();
    description.markers = vec![Marker {
        dictionary,
        id: 0,
        size_mm: 600.0,
        pose,
    }];
    description
}

/// Position of a world direction in an equirect picture of a body at the origin.
fn equirect_px(to: Point3<f64>, width: f64, height: f64) -> [f64; 2] {
    use std::f64::consts::PI;
    let yaw = libm::atan2(to.y, to.x);
    let pitch = -libm::asin(to.z / to.coords.norm());
    [
        (PI - yaw) * width / (2.0 * PI) - 0.5,
        (pitch + PI / 2.0) * height / PI - 0.5,
    ]
}

#[test]
fn board_corners_are_where_the_truth_says_and_lie_left_to_right() {
    let scene = Scene::new(&printed()).unwrap();
    for j in 0..4 {
        for i in 0..5 {
            let corner = scene.board_corner_m(0, i, j).unwrap();
            let hit = scene
                .trace(&Ray::new(Point3::origin(), corner.coords))
                .unwrap();
            assert_eq!(hit.seen, Seen::Board(0));
            // Rounding of a few operations on metres.
            assert!((hit.range_m - corner.coords.norm()).abs() < 1e-14);
            let expected = [(f64::from(i) - 2.0) * 0.15, (f64::from(j) - 1.5) * 0.15];
            assert!((hit.surface_m[0] - expected[0]).abs() < 1e-14);
            assert!((hit.surface_m[1] - expected[1]).abs() < 1e-14);
        }
    }
    let corner = |i, j| scene.board_corner_m(0, i, j).unwrap();
    // The board hangs ahead: its columns run to the right (y falls), its rows down.
    assert!(corner(4, 0).y < corner(0, 0).y - 0.5);
    assert!(corner(0, 3).z < corner(0, 0).z - 0.4);
    assert!(scene.board_corner_m(0, 5, 0).is_none());
    assert!(scene.board_corner_m(0, 0, 4).is_none());
    assert!(scene.board_corner_m(1, 0, 0).is_none());
}

#[test]
fn a_picture_changes_colour_at_every_projected_corner() {
    let scene = Scene::new(&printed()).unwrap();
    let (width, height) = (1440, 720);
    let view = equirect(width, height, Pose::default());
    let picture = render(&scene, width, height, &view, &RenderOptions::default()).unwrap();
    let red = |[x, y]: [f64; 2]| {
        picture.rgb[3 * (y.round() as usize * width as usize + x.round() as usize)]
    };
    let px = |p| equirect_px(p, f64::from(width), f64::from(height));
    for j in 0..4 {
        for i in 0..5 {
            let corner = scene.board_corner_m(0, i, j).unwrap();
            // Half a square along both diagonals of the grid, from neighbouring corners.
            let (next, below) = (
                scene.board_corner_m(0, (i + 1) % 5, j).unwrap(),
                scene.board_corner_m(0, i, (j + 1) % 4).unwrap(),
            );
            let (u, v) = (
                (next - corner).normalize() * 0.04,
                (below - corner).normalize() * 0.04,
            );
            let along = if i == 4 { -u } else { u };
            let down = if j == 3 { -v } else { v };
            let (same, other) = (
                [
                    red(px(corner + along + down)),
                    red(px(corner - along - down)),
                ],
                [
                    red(px(corner + along - down)),
                    red(px(corner - along + down)),
                ],
            );
            // Inner corner (0, 0) has black at its top left and bottom right.
            let (black, white) = if (i + j) % 2 == 0 {
                (same, other)
            } else {
                (other, same)
            };
            assert!(black.iter().all(|b| *b < 70), "{i} {j} {black:?}");
            assert!(white.iter().all(|w| *w > 120), "{i} {j} {white:?}");
        }
    }
}

#[test]
fn a_marker_reads_as_opencv_prints_it() {
    let scene = Scene::new(&printed()).unwrap();
    let pose = Pose {
        yaw_deg: 170.0,
        pitch_deg: -4.0,
        ..Pose::default()
    };
    let view = equidistant(400, 120.0, pose);
    let picture = render(&scene, 400, 400, &view, &RenderOptions::default()).unwrap();
    let corners = scene.marker_corners_m(0).unwrap();
    let right = (corners[1] - corners[0]) / 6.0;
    let down = (corners[3] - corners[0]) / 6.0;
    assert!((corners[2] - corners[0] - (right + down) * 6.0).norm() < 1e-14);
    let mut text = String::new();
    for j in -1..7 {
        for i in -1..7 {
            let center = corners[0] + right * (f64::from(i) + 0.5) + down * (f64::from(j) + 0.5);
            // The pixel whose true direction is the nearest to the cell's centre.
            let to = center.coords.normalize();
            let nearness =
                |t: &Option<Truth>| t.map_or(-1.0, |t| Vector3::from(t.direction).dot(&to));
            let (k, _) = picture
                .truth
                .iter()
                .map(nearness)
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap();
            assert_eq!(picture.truth[k].unwrap().seen, Seen::Marker(0));
            text.push(if picture.rgb[3 * k] > 100 { '.' } else { '#' });
        }
        text.push('\n');
    }
    // DICT_4X4_50 id 0 is the bytes 181, 50 in OpenCV: 1011 0101 0011 0010, 1 is white.
    let expected = "\
........
.######.
.#.#..#.
.##.#.#.
.###..#.
.###.##.
.######.
........
";
    assert_eq!(text, expected);
}

#[test]
fn a_panel_from_behind_is_blank() {
    let mut description = printed();
    description.boards[0].pose.yaw_deg -= 180.0;
    let scene = Scene::new(&description).unwrap();
    let corner = scene.board_corner_m(0, 2, 1).unwrap();
    let hit = scene
        .trace(&Ray::new(Point3::origin(), corner.coords))
        .unwrap();
    assert_eq!(hit.seen, Seen::Backing);
}
