//! The pool that the demo swims in.

use crate::description::{Board, Marker, PanelPose, Pool, SceneDescription, Shape, Solid};
use crate::medium::Medium;

const WHITE: [f64; 3] = [0.82, 0.82, 0.80];
const RED: [f64; 3] = [0.75, 0.05, 0.04];
const ORANGE: [f64; 3] = [0.90, 0.28, 0.03];
const YELLOW: [f64; 3] = [0.88, 0.62, 0.04];
const GREEN: [f64; 3] = [0.06, 0.45, 0.12];
const BLUE: [f64; 3] = [0.04, 0.12, 0.55];
const BLACK: [f64; 3] = [0.03, 0.03, 0.035];
const STEEL: [f64; 3] = [0.55, 0.58, 0.60];

impl SceneDescription {
    /// A 12 x 8 x 2.4 m pool with boards, markers, buoys, a gate, lane ropes and a ladder, seen
    /// best from the origin: things stand on both sides, above, below, and across the line
    /// straight ahead where the views of two sideways eyes meet.
    pub fn furnished(medium: Medium) -> Self {
        Self {
            texture_seed: 2,
            pool: Pool {
                length_m: 12.0,
                width_m: 8.0,
                depth_m: 2.4,
                freeboard_m: 0.3,
                tile_mm: 150.0,
            },
            medium,
            boards: boards(),
            markers: markers(),
            solids: [gate(), buoys(), lane_ropes(), floor_toys(), ladder()].concat(),
        }
    }
}

fn boards() -> Vec<Board> {
    let board = |columns, rows, square_mm, position_m, yaw_deg, pitch_deg, roll_deg| Board {
        columns,
        rows,
        square_mm,
        pose: PanelPose {
            position_m,
            yaw_deg,
            pitch_deg,
            roll_deg,
        },
    };
    vec![
        board(8, 6, 110.0, [1.75, -0.12, 0.10], 176.0, 6.0, 3.0),
        board(8, 6, 110.0, [0.55, 2.10, 0.15], -102.0, -8.0, -6.0),
        board(8, 6, 110.0, [-0.10, -2.25, -0.25], 88.0, -10.0, 5.0),
    ]
}

fn markers() -> Vec<Marker> {
    let marker = |id, size_mm, position_m, yaw_deg, pitch_deg| Marker {
        dictionary: "DICT_4X4_50".into(),
        id,
        size_mm,
        pose: PanelPose {
            position_m,
            yaw_deg,
            pitch_deg,
            roll_deg: 0.0,
        },
    };
    vec![
        marker(0, 700.0, [5.98, 2.90, 0.15], 180.0, 0.0),
        marker(1, 700.0, [5.98, -2.90, 0.15], 180.0, 0.0),
        marker(2, 600.0, [2.60, 3.98, 0.30], -90.0, 0.0),
        marker(3, 600.0, [-1.60, 3.98, 0.30], -90.0, 0.0),
        marker(4, 600.0, [2.40, -3.98, 0.30], 90.0, 0.0),
        marker(5, 600.0, [-2.60, -3.98, 0.30], 90.0, 0.0),
        marker(6, 700.0, [-5.98, 0.00, 0.20], 0.0, 0.0),
        // On the floor, read from the pool's back end.
        marker(7, 600.0, [1.30, 0.95, -1.195], 180.0, -90.0),
        marker(8, 600.0, [0.70, -1.20, -1.195], 180.0, -90.0),
    ]
}

fn pole(from_m: [f64; 3], to_m: [f64; 3], radius_mm: f64, paint: Paint) -> Solid {
    paint.on(Shape::Pole {
        from_m,
        to_m,
        radius_mm,
    })
}

fn ball(center_m: [f64; 3], radius_mm: f64, paint: Paint) -> Solid {
    paint.on(Shape::Sphere {
        center_m,
        radius_mm,
    })
}

/// Two colours and the width of their bands, mm.
#[derive(Clone, Copy)]
struct Paint([f64; 3], [f64; 3], f64);

impl Paint {
    fn on(self, shape: Shape) -> Solid {
        Solid {
            shape,
            color: self.0,
            band_color: self.1,
            band_mm: self.2,
        }
    }
}

/// A gate to swim through, 3.2 m ahead.
fn gate() -> Vec<Solid> {
    let paint = Paint(ORANGE, WHITE, 200.0);
    vec![
        pole([3.2, 1.15, -1.2], [3.2, 1.15, 0.75], 45.0, paint),
        pole([3.2, -1.15, -1.2], [3.2, -1.15, 0.75], 45.0, paint),
        pole([3.2, 1.15, 0.75], [3.2, -1.15, 0.75], 45.0, paint),
    ]
}

/// Buoys on tethers to the floor, and two at the surface.
fn buoys() -> Vec<Solid> {
    let tethered = |x, y, z, radius_mm, paint| {
        let rope = Paint(WHITE, BLACK, 60.0);
        [
            ball([x, y, z], radius_mm, paint),
            pole([x, y, -1.2], [x, y, z], 8.0, rope),
        ]
    };
    let mut buoys = [
        tethered(1.25, 1.35, -0.10, 170.0, Paint(ORANGE, WHITE, 110.0)),
        tethered(1.45, -1.55, 0.20, 190.0, Paint(RED, YELLOW, 90.0)),
        tethered(-1.20, 1.75, 0.05, 210.0, Paint(YELLOW, BLACK, 140.0)),
        tethered(-1.35, -1.45, -0.25, 200.0, Paint(GREEN, WHITE, 90.0)),
        tethered(3.90, 0.45, -0.35, 230.0, Paint(RED, WHITE, 150.0)),
        tethered(-3.20, 0.60, 0.10, 230.0, Paint(BLUE, WHITE, 150.0)),
    ]
    .concat();
    buoys.push(ball([0.45, 0.75, 1.12], 160.0, Paint(YELLOW, RED, 80.0)));
    buoys.push(ball([1.70, -0.70, 1.12], 160.0, Paint(WHITE, RED, 80.0)));
    buoys
}

fn lane_ropes() -> Vec<Solid> {
    let rope = |y, paint| pole([-5.9, y, 1.17], [5.9, y, 1.17], 55.0, paint);
    vec![
        rope(2.6, Paint(RED, WHITE, 300.0)),
        rope(-2.6, Paint(BLUE, YELLOW, 300.0)),
    ]
}

/// Crates and a diving stick on the floor.
fn floor_toys() -> Vec<Solid> {
    let crate_at = |center_m, size_mm, yaw_deg, paint: Paint| {
        paint.on(Shape::Box {
            center_m,
            size_mm,
            yaw_deg,
        })
    };
    vec![
        crate_at(
            [2.3, 1.75, -0.95],
            [500.0, 500.0, 500.0],
            25.0,
            Paint(YELLOW, BLUE, 125.0),
        ),
        crate_at(
            [2.45, -1.80, -1.00],
            [600.0, 400.0, 400.0],
            -30.0,
            Paint(RED, WHITE, 100.0),
        ),
        crate_at(
            [-0.95, 0.45, -1.05],
            [400.0, 300.0, 300.0],
            60.0,
            Paint(GREEN, YELLOW, 75.0),
        ),
        crate_at(
            [-2.40, -2.00, -0.90],
            [600.0, 600.0, 600.0],
            10.0,
            Paint(BLUE, ORANGE, 150.0),
        ),
        crate_at(
            [-2.60, 2.30, -0.80],
            [500.0, 500.0, 800.0],
            -15.0,
            Paint(ORANGE, BLACK, 200.0),
        ),
        pole(
            [0.35, -0.75, -1.17],
            [0.95, -0.45, -1.17],
            30.0,
            Paint(ORANGE, BLACK, 100.0),
        ),
    ]
}

/// Steel steps on the right wall that go up out of the water.
fn ladder() -> Vec<Solid> {
    let paint = Paint(STEEL, STEEL, 1000.0);
    let rail = |x| pole([x, -3.85, -0.6], [x, -3.85, 1.9], 28.0, paint);
    let step = |z| pole([0.85, -3.85, z], [1.45, -3.85, z], 22.0, paint);
    vec![
        rail(0.85),
        rail(1.45),
        step(-0.5),
        step(-0.1),
        step(0.3),
        step(0.7),
        step(1.1),
    ]
}
