//! From printed boards to directions, by the program's own commands with their defaults, beside the
//! truth: a mount whose eyes are 4 degrees and 5 mm off what its drawing says.
//!
//! `cargo xtask campaign chain` prints the figures.

#[allow(dead_code, reason = "the tests of single verbs need more of it")]
#[path = "../cli/common.rs"]
mod common;

use std::fs;

use common::Bench;
use nalgebra::{Unit, Vector3};
use tectum_core::{Eye, Tables};
use tectum_optics::convention::{angle_between, yaw_pitch};
use tectum_optics::{Pose, Rig};
use tectum_scene::Medium;

/// Pictures of the lens's board that each eye takes, and pictures of the board between the eyes.
const LENS_SHOTS: usize = 24;
const OVERLAP_SHOTS: usize = 6;
const FAR_M: f64 = 2.0;

/// A fish as drawn, and the pool that it is in.
struct Fish {
    /// Field, lenses and medium of the rig's file, as they really are.
    eyes: [String; 2],
    medium: &'static str,
    half_field_deg: f64,
    /// How far to the sides and along the middle of the overlap boards can be, and how far away.
    reach: f64,
    board_distance_m: f64,
}

impl Fish {
    fn in_air() -> Self {
        let lens = |centre: [f64; 2]| {
            format!(
                "size_px = [480, 480]\nfield_deg = 210.0\nlens = {{ model = \"kannala_brandt\", \
                 focal_px = [131.2, 131.2], centre_px = {centre:?}, \
                 distortion = [-0.012, 0.0015, 0.0, 0.0] }}\n"
            )
        };
        Self {
            eyes: [lens([241.3, 238.1]), lens([237.9, 240.6])],
            medium: "air",
            half_field_deg: 105.0,
            reach: 1.0,
            board_distance_m: 0.27,
        }
    }

    /// The paper's fish as it sees in water, by the kappa that its measured field tells.
    fn in_water() -> Self {
        let shipped = include_str!("../../../../tables/rigs/paper-fish-in-water.toml");
        let shipped: toml::Table = shipped.parse().expect("a rig");
        let eye = |name: &str| toml::to_string(&shipped[name]).expect("an eye");
        Self {
            eyes: ["left", "right"]
                .map(|name| eye(name).replace("[lens]", &format!("[{name}.lens]"))),
            medium: "water",
            half_field_deg: 77.9,
            reach: 0.3,
            board_distance_m: 0.55,
        }
    }

    fn rig(&self, eyes: &[String; 2]) -> String {
        let Self { medium, .. } = self;
        let [left, right] = eyes;
        format!(
            "name = \"fish\"\nmedium = \"{medium}\"\nstitch_distance_m = {FAR_M:?}\n[mount]\n\
             psi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{left}\n[right]\n{right}\n"
        )
    }

    /// The rig as it was built.
    fn built(&self) -> Rig {
        off_mount(&Rig::from_toml(&self.rig(&self.eyes), "drawn.toml").expect("a rig"))
    }

    /// A pool with what hangs in it.
    fn scene(&self, panels: &str) -> String {
        let medium = match self.medium {
            "air" => Medium::Air,
            _ => Medium::default(),
        };
        let medium = toml::Value::try_from(medium).expect("a medium");
        format!(
            "texture_seed = 1\npool = {{ length_m = 12.0, width_m = 12.0, depth_m = 12.0, \
             freeboard_m = 0.3, tile_mm = 200.0 }}\nmedium = {medium}\n{panels}"
        )
    }
}

/// A rig whose eyes are turned by 2 degrees and moved by 2.5 mm, each the other way.
fn off_mount(rig: &Rig) -> Rig {
    let axis = Unit::new_normalize(Vector3::new(0.5, 0.6, -0.62));
    let shift_m = Vector3::new(0.0011, -0.0018, 0.0013).normalize() * 0.0025;
    let poses = [(&rig.left, 1.0), (&rig.right, -1.0)].map(|(eye, sign)| {
        let pose = eye.as_ref().expect("two eyes").pose;
        let turn = nalgebra::Rotation3::from_axis_angle(&axis, sign * 2f64.to_radians());
        Pose {
            rotation: turn * pose.rotation,
            position_m: pose.position_m + shift_m * sign,
        }
    });
    rig.with_poses(poses).expect("a mount")
}

/// A flat thing, its middle `distance_m` away in a body direction, tilted away from facing the body.
struct Panel {
    position_m: Vector3<f64>,
    yaw_deg: f64,
    pitch_deg: f64,
}

impl Panel {
    fn facing(direction: &Vector3<f64>, distance_m: f64, tilt_deg: [f64; 2]) -> Self {
        let (yaw, pitch) = yaw_pitch(&-direction);
        Self {
            position_m: direction * distance_m,
            yaw_deg: yaw.to_degrees() + tilt_deg[0],
            pitch_deg: pitch.to_degrees() + tilt_deg[1],
        }
    }

    fn pose(&self, roll_deg: f64) -> String {
        let [x, y, z]: [f64; 3] = self.position_m.into();
        format!(
            "pose = {{ position_m = [{x:?}, {y:?}, {z:?}], yaw_deg = {:?}, pitch_deg = {:?}, \
             roll_deg = {roll_deg:?} }}\n",
            self.yaw_deg, self.pitch_deg
        )
    }

    /// The chessboard of `board --board COLUMNSxROWS`.
    fn board(&self, [columns, rows]: [u32; 2], square_mm: f64, roll_deg: f64) -> String {
        format!(
            "[[boards]]\ncolumns = {columns}\nrows = {rows}\nsquare_mm = {square_mm:?}\n{}",
            self.pose(roll_deg)
        )
    }

    /// The marker of the board between the eyes, `left_m` to the left of the panel's middle.
    fn marker(&self, size_mm: f64, left_m: f64) -> String {
        let (sin, cos) = self.yaw_deg.to_radians().sin_cos();
        let beside = Self {
            position_m: self.position_m - left_m * Vector3::new(-sin, cos, 0.0),
            ..*self
        };
        format!(
            "[[markers]]\ndictionary = \"DICT_4X4_50\"\nid = 7\nsize_mm = {size_mm:?}\n{}",
            beside.pose(0.0)
        )
    }
}

/// Simulates what the fish as built sees of a scene: left and right picture.
fn shot(bench: &Bench, fish: &Fish, panels: &str, seed: usize) -> [std::path::PathBuf; 2] {
    fs::write(bench.path("scene.toml"), fish.scene(panels)).expect("a scene");
    let seed = format!("--seed {seed}");
    bench.done(&format!(
        "simulate built.toml -o shot --scene scene.toml {seed}"
    ));
    ["left", "right"].map(|eye| bench.path(&format!("shot/{eye}.png")))
}

fn lens_pictures(bench: &Bench, fish: &Fish, built: &Rig) {
    for (index, (name, eye)) in [("left", &built.left), ("right", &built.right)]
        .iter()
        .enumerate()
    {
        let pose = eye.as_ref().expect("two eyes").pose;
        fs::create_dir_all(bench.path(&format!("lens-{name}"))).expect("a folder");
        for k in 0..LENS_SHOTS {
            let t = k as f64;
            let off_axis = (fish.half_field_deg - 20.0) * ((t + 0.5) / LENS_SHOTS as f64).sqrt();
            let (sin, cos) = off_axis.to_radians().sin_cos();
            let turn = 2.4 * t;
            let direction = Vector3::new(sin * turn.cos(), sin * turn.sin(), cos);
            let tilt_deg = [28.0 * (1.3 * t).sin(), 28.0 * (2.1 * t).cos()];
            let distance_m = 0.24 + 0.05 * (k % 3) as f64;
            let panel = Panel::facing(&(pose.rotation * direction), distance_m, tilt_deg);
            let pictures = shot(
                bench,
                fish,
                &panel.board([9, 6], 21.0, 35.0 * t),
                100 * index + k,
            );
            let to = bench.path(&format!("lens-{name}/{k:02}.png"));
            fs::copy(&pictures[index], to).expect("a picture");
        }
    }
}

fn overlap_pictures(bench: &Bench, fish: &Fish) {
    for k in 0..OVERLAP_SHOTS {
        let t = k as f64;
        // The middle of the overlap is 68 degrees up.
        let side = 0.25 * fish.reach * (2.4 * t).sin();
        let along = 1.19 + 0.6 * fish.reach * (1.9 * t).cos();
        let direction = Vector3::new(
            side.cos() * along.cos(),
            side.sin(),
            side.cos() * along.sin(),
        );
        let tilt_deg = [20.0 * (1.7 * t).sin(), 20.0 * (2.9 * t).cos()];
        let distance_m = fish.board_distance_m * (1.0 + 0.15 * (k % 3) as f64);
        let panel = Panel::facing(&direction, distance_m, tilt_deg);
        let panels = panel.board([8, 6], 17.0, 0.0) + &panel.marker(68.0, 0.1225);
        let pictures = shot(bench, fish, &panels, 300 + k);
        for (from, eye) in pictures.iter().zip(["l", "r"]) {
            fs::create_dir_all(bench.path(eye)).expect("a folder");
            fs::copy(from, bench.path(&format!("{eye}/{k}.png"))).expect("a picture");
        }
    }
}

/// Stitched pictures of the paper's board on each side: 11x8 corners, 35 mm, 160 mm away.
fn orientation_pictures(bench: &Bench, fish: &Fish) {
    bench.done("bake fish.toml -o fish.tct --size 2048x1024");
    for (name, side) in [("beside-left", 1.0), ("beside-right", -1.0)] {
        let panel = Panel {
            position_m: Vector3::new(0.105, 0.16 * side, 0.0525),
            yaw_deg: -90.0 * side,
            pitch_deg: 0.0,
        };
        let [left, right] = shot(bench, fish, &panel.board([11, 8], 35.0, 0.0), 400);
        let eyes = format!("--left {} --right {}", left.display(), right.display());
        bench.done(&format!("stitch fish.tct {eyes} -o {name}.png"));
    }
}

/// RMS and worst angle between the direction that each pixel of the stitched picture stands for and the
/// one that it really shows at the stitch distance, degrees, and the number of pixels.
fn direction_errors_deg(table: &[u8], built: &Rig) -> [f64; 3] {
    let tables = Tables::parse(table).expect("a table");
    let output = tectum_bake::output_map(&tables);
    let eyes = [(Eye::Left, &built.left), (Eye::Right, &built.right)];
    let (mut squares, mut worst, mut count) = (0.0, 0.0f64, 0.0);
    for row in 0..tables.output_height_px() {
        for run in tables.runs(row) {
            for (side, eye) in eyes {
                use tectum_tables::RunKind::{Blend, Left, Right};
                let shows = match run.kind {
                    Left => side == Eye::Left,
                    Right => side == Eye::Right,
                    Blend(_) => true,
                    tectum_tables::RunKind::Void => false,
                };
                let (true, Some(eye), Some(mesh)) = (shows, eye, tables.mesh(side)) else {
                    continue;
                };
                let mut column = run.start;
                for mut segment in mesh.segments(row, run.start, run.len) {
                    for _ in 0..segment.len {
                        let at = [segment.x, segment.y]
                            .map(|axis| f64::from(axis.position_q8()) / 256.0);
                        let stands_for = output
                            .ray(f64::from(column), f64::from(row))
                            .expect("inside");
                        // What lies beyond the real lens's field is dark: the found rim is not exact.
                        if let Ok(shows) = eye.direction_of(at, FAR_M) {
                            let off = angle_between(&shows, &stands_for).to_degrees();
                            squares += off * off;
                            worst = worst.max(off);
                            count += 1.0;
                        }
                        segment.step();
                        column += 1;
                    }
                }
            }
        }
    }
    [(squares / count).sqrt(), worst, count]
}

fn whole_way(fish: &Fish) {
    let bench = Bench::new();
    let built = fish.built();
    fs::write(bench.path("built.toml"), built.to_toml().expect("a rig")).expect("a file");
    bench.done("board --board 9x6 -o board.pdf");
    bench.done("board --board 8x6 --marker 7 -o overlap.pdf");
    lens_pictures(&bench, fish, &built);
    for eye in ["left", "right"] {
        let medium = fish.medium;
        let found = bench.json(&format!(
            "calibrate lens-{eye} --board 9x6 --square-mm 21 --medium {medium} -o {eye}.toml"
        ));
        println!(
            "{eye} lens: {} of {LENS_SHOTS} pictures, {} corners, {} px RMS, {}",
            found["accepted"], found["corners"], found["rms_px"], found["model"]
        );
    }
    let files = ["left", "right"].map(|eye| format!("file = \"{eye}.toml\"\n"));
    fs::write(bench.path("rig.toml"), fish.rig(&files)).expect("a rig");
    overlap_pictures(&bench, fish);
    let registered = registered(&bench, "--left l --right r --target overlap.json");
    let relative = |rig: &Rig| {
        let [left, right] = [&rig.left, &rig.right].map(|eye| eye.as_ref().expect("two eyes").pose);
        (
            left.rotation.inverse() * right.rotation,
            left.rotation.inverse() * (right.position_m - left.position_m),
        )
    };
    let (turn, place) = (relative(&registered), relative(&built));
    println!(
        "relative pose: {:.4} degrees and {:.3} mm off",
        (turn.0 * place.0.inverse()).angle().to_degrees(),
        (turn.1 - place.1).norm() * 1e3
    );
    orientation_pictures(&bench, fish);
    let found = bench.json(
        "align fish.tct --rig fish.toml --board-left beside-left.png --board-right \
         beside-right.png --board 11x8 --square-mm 35 --distance-mm 160 --origin 2,2 -o aligned.toml",
    );
    println!(
        "orientation: {} degrees RMS before, {} after",
        found["rms_deg"], found["turned_rms_deg"]
    );
    // The smaller table of the two: what the eyes do not see takes memory for nothing.
    let [bytes, fitted] = ["", "--fit"].map(|fit| {
        let ([rms, _], bytes) = baked(&bench, "aligned.toml", fit, &built);
        assert!(rms <= 0.05, "{rms}");
        bytes
    });
    assert!(bytes.min(fitted) <= 16 * 1024, "{bytes} {fitted}");
}

/// Registers `rig.toml` to `fish.toml`, prints what was found, and gives the rig.
fn registered(bench: &Bench, pictures: &str) -> Rig {
    let found = bench.json(&format!("register rig.toml {pictures} -o fish.toml"));
    println!(
        "registration: {} corners in {} pairs, {} px RMS; turned by {} degrees, standard error {}",
        found["inliers"],
        found["pairs"],
        found["rms_px"],
        found["registration"]["turn_deg"],
        found["registration"]["turn_standard_error_deg"],
    );
    Rig::load(&bench.path("fish.toml")).expect("a rig")
}

/// Bakes a rig, prints what its table tells beside the rig as built, and gives RMS and worst error,
/// degrees, and its bytes.
fn baked(bench: &Bench, rig: &str, options: &str, built: &Rig) -> ([f64; 2], u64) {
    let report = bench.json(&format!("bake {rig} -o baked.tct {options}"));
    let bytes = report["bytes"]["total"].as_u64().expect("bytes");
    let table = fs::read(bench.path("baked.tct")).expect("a table");
    let [rms, worst, pixels] = direction_errors_deg(&table, built);
    println!(
        "bake {options}: directions of {pixels} pixels {rms:.4} degrees RMS, {worst:.4} worst; {bytes} bytes"
    );
    ([rms, worst], bytes)
}

#[test]
#[ignore = "campaign chain: 56 pictures, a minute"]
fn in_air() {
    whole_way(&Fish::in_air());
}

#[test]
#[ignore = "campaign chain: 56 pictures, a minute"]
fn in_water() {
    whole_way(&Fish::in_water());
}

/// Real pictures without a marker, lenses and poses as published: from a rig that is off, by registration, to a
/// table. There are no orientation boards; the rig is off evenly, so that none are needed.
#[test]
#[ignore = "campaign chain: real pictures"]
fn of_real_pictures() {
    let Some(folder) = tectum_test_data::data("rig220-sweepnet") else {
        return;
    };
    let rigs = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tables/rigs/sweepnet-1-3.toml"
    );
    let published = Rig::load(rigs.as_ref()).expect("a rig");
    let bench = Bench::new();
    let off = off_mount(&published).to_toml().expect("a rig");
    fs::write(bench.path("rig.toml"), off).expect("a file");
    let [left, right] = ["cam1", "cam3"].map(|eye| folder.join(eye).display().to_string());
    registered(&bench, &format!("--left {left} --right {right}"));
    // The published poses have errors of their own.
    let ([rms, worst], _) = baked(&bench, "fish.toml", "", &published);
    assert!(rms <= 0.15 && worst <= 0.3, "{rms} {worst}");
}
