//! Section: the boards and both eyes where they were, from four sides.

use nalgebra::Vector3;
use tectum_optics::Pose;
use tectum_page::svg::{Path, captioned, drawing, text};

use super::RigReportInput;
use crate::{Board, BoardPose};

/// A drawing's size, user units, and its margin.
const SIZE: [f64; 2] = [560.0, 400.0];
const MARGIN: f64 = 26.0;
/// Length of the arrow of an optical axis, in the drawing's larger extent.
const AXIS: f64 = 0.15;

/// One eye's picture of a board: its outline in the body frame, mm.
struct Outline {
    corners_mm: [Vector3<f64>; 4],
    class: &'static str,
}

/// From the body frame, mm, to a plane, right and up.
type Side = fn(&Vector3<f64>) -> [f64; 2];

pub fn html(input: &RigReportInput) -> String {
    let poses = input.both.poses();
    let outlines = outlines(input, &poses);
    let sides: [(Side, &str); 4] = [
        (oblique, "From behind, above and to the right."),
        (|p| [-p.y, p.x], "From above: ahead is up, left is left."),
        (|p| [-p.y, p.z], "From behind: up is up, left is left."),
        (|p| [p.x, p.z], "From the right: ahead is to the right."),
    ];
    let drawn: String = sides
        .iter()
        .map(|(side, words)| captioned(&draw(*side, words, &outlines, &poses), words))
        .collect();
    format!(
        "<section id=\"space\"><h2>Boards and both eyes</h2>\n<p>Blue: a board as the left eye's picture says, \
         green as the right eye's says; where both see it the outlines cover each other. Red: pairs left \
         out. Lines from L and R: the optical axes.</p>\n<div class=\"two\">{drawn}</div></section>\n"
    )
}

fn oblique(p: &Vector3<f64>) -> [f64; 2] {
    [-p.y + 0.45 * p.x, p.z + 0.35 * p.x]
}

fn outlines(input: &RigReportInput, poses: &[Pose; 2]) -> Vec<Outline> {
    let mut outlines = Vec::new();
    for (eye, pose) in poses.iter().enumerate() {
        for (pair, view) in input.eyes[eye].views.iter().enumerate() {
            let Some(board_pose) = view.pose.filter(|_| view.rejection.is_none()) else {
                continue;
            };
            let is_out = input.both.left_out.iter().any(|out| out.pair == pair);
            outlines.push(Outline {
                corners_mm: outline(&input.board, &board_pose, pose),
                class: match (is_out, eye) {
                    (true, _) => "red",
                    (false, 0) => "blue faint",
                    (false, _) => "green faint",
                },
            });
        }
    }
    outlines
}

/// The board's outermost inner corners in the body frame, mm.
fn outline(board: &Board, camera_from_board: &BoardPose, eye: &Pose) -> [Vector3<f64>; 4] {
    let (i, j) = (board.size.columns - 1, board.size.rows - 1);
    [(0, 0), (i, 0), (i, j), (0, j)].map(|(i, j)| {
        let in_camera_mm = camera_from_board.apply(&board.corner_mm(i, j));
        eye.rotation * in_camera_mm + eye.position_m * 1000.0
    })
}

fn draw(side: Side, words: &str, outlines: &[Outline], poses: &[Pose; 2]) -> String {
    let eyes_mm = poses.map(|pose| pose.position_m * 1000.0);
    let points = outlines.iter().flat_map(|outline| &outline.corners_mm);
    let points: Vec<[f64; 2]> = points.chain(&eyes_mm).map(side).collect();
    let range = |k: usize| {
        let values = points
            .iter()
            .map(|point| point[k])
            .filter(|v| v.is_finite());
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
            [a.min(v), b.max(v)]
        })
    };
    let (x, y) = (range(0), range(1));
    let extent = (x[1] - x[0]).max(y[1] - y[0]).max(1e-6);
    let scale = ((SIZE[0] - 2.0 * MARGIN) / (x[1] - x[0]).max(1e-6))
        .min((SIZE[1] - 2.0 * MARGIN) / (y[1] - y[0]).max(1e-6));
    let place = |p: &Vector3<f64>| {
        let [px, py] = side(p);
        [
            SIZE[0] / 2.0 + (px - (x[0] + x[1]) / 2.0) * scale,
            SIZE[1] / 2.0 - (py - (y[0] + y[1]) / 2.0) * scale,
        ]
    };
    let mut body = String::new();
    for outline in outlines {
        let [first, ..] = outline.corners_mm;
        let around = outline.corners_mm.iter().chain([&first]);
        body += &Path::through(around.map(place)).element(outline.class);
    }
    for ((pose, at_mm), name) in poses.iter().zip(&eyes_mm).zip(["L", "R"]) {
        let ahead = at_mm + pose.optical_axis() * (AXIS * extent);
        body += &Path::through([place(at_mm), place(&ahead)]).element("curve");
        let [x, y] = place(at_mm);
        body += &Path::dots([[x, y]]).element("dot used");
        body += &text("mid halo", [x, y + 16.0], name);
    }
    drawing(SIZE, words, &body)
}
