//! Every shell line of the README and of `docs` on simulated pictures. Lines run as they stand there, but for the
//! address of a live view; between some lines smaller tables and rigs take the place of large ones.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use image::RgbImage;

use crate::boards;
use crate::common::Bench;
use crate::page::Viewing;

const README: &str = include_str!("../../../../README.md");

/// Lines that build, test or install: other steps of the gate do the same.
const OTHERS: [&str; 4] = [
    "cargo demo",
    "cargo xtask test",
    "cargo build --release && PATH=$PWD/target/release:$PATH",
    "apt-get install libclang-dev && cargo build --release --features v4l2",
];

/// Both circles of the paper's fish in one picture, which each eye of it takes its own of.
const FISH: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
    mount = { psi_deg = 25.7, tau_deg = 29.15, lateral_mm = 30.0 }\n\
    [left]\nsize_px = [480, 240]\nfield_deg = 210.0\n\
    lens = { model = \"equidistant\", focal_px_per_rad = 64.935217, centre_px = [119.5, 119.5] }\n\
    [right]\nsize_px = [480, 240]\nfield_deg = 210.0\n\
    lens = { model = \"equidistant\", focal_px_per_rad = 64.935217, centre_px = [359.5, 119.5] }\n";
const POOL: &str = "texture_seed = 1\npool = { length_m = 6.0, width_m = 6.0, depth_m = 4.0, \
    freeboard_m = 0.3, tile_mm = 150.0 }\nmedium = { kind = \"air\" }\n";

/// The pages of `docs` that have shell lines; a test for each is below.
const PAGES: [(&str, &str); 7] = [
    ("design", include_str!("../../../../docs/design.md")),
    (
        "calibration",
        include_str!("../../../../docs/calibration.md"),
    ),
    (
        "registration",
        include_str!("../../../../docs/registration.md"),
    ),
    (
        "orientation",
        include_str!("../../../../docs/orientation.md"),
    ),
    ("cameras", include_str!("../../../../docs/cameras.md")),
    ("stitching", include_str!("../../../../docs/stitching.md")),
    ("lookup", include_str!("../../../../docs/lookup.md")),
];

/// The commands of a page of `docs`.
fn commands(page: &str) -> Vec<String> {
    let text = PAGES.iter().find(|(name, _)| *name == page);
    shell_lines(text.expect("a page").1)
}

/// The commands of a text's shell blocks without comments, lines that go on joined.
fn shell_lines(text: &str) -> Vec<String> {
    let blocks = text.split("```").skip(1).step_by(2);
    let shell = blocks.filter_map(|block| block.strip_prefix("sh\n"));
    let joined = shell.map(|block| block.replace("\\\n", " "));
    let lines: Vec<String> = joined
        .flat_map(|block| block.lines().map(str::to_owned).collect::<Vec<_>>())
        .map(|line| {
            line.split(" # ")
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned()
        })
        .collect();
    lines
        .into_iter()
        .filter(|line| !OTHERS.contains(&&**line))
        .collect()
}

/// A shell that has the program, in the bench's folder.
fn shell(bench: &Bench, line: &str) -> Command {
    let program = Path::new(env!("CARGO_BIN_EXE_tectum"));
    let folder = program.parent().expect("a folder").display();
    let path = std::env::var("PATH").unwrap_or_default();
    let mut shell = bench.command("sh");
    shell
        .args(["-c", line])
        .env("PATH", format!("{folder}:{path}"));
    shell
}

fn run(bench: &Bench, line: &str) {
    let begun = Instant::now();
    let output = shell(bench, line).output().expect("a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {stderr}");
    println!("{:.1} s: {line}", begun.elapsed().as_secs_f64());
}

fn run_all(bench: &Bench, page: &str) {
    commands(page).iter().for_each(|line| run(bench, line));
}

/// Simulates `FISH` in a scene; the pictures are `NAME/left.png` and `NAME/right.png`.
fn simulate(bench: &Bench, name: &str, scene: &str) {
    fs::write(bench.path("scene.toml"), format!("{POOL}{scene}")).unwrap();
    run(
        bench,
        &format!("tectum simulate rig.toml -o {name} --scene scene.toml --samples 1"),
    );
}

#[test]
fn every_line_is_run() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs"));
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_some_and(|end| end == "md") {
            let has_lines = !shell_lines(&fs::read_to_string(&path).unwrap()).is_empty();
            let name = path.file_stem().unwrap().to_string_lossy();
            let is_known = PAGES.iter().any(|(page, _)| *page == name);
            assert_eq!(has_lines, is_known, "{}", path.display());
        }
    }
    let run: Vec<String> = PAGES.iter().flat_map(|(page, _)| commands(page)).collect();
    // The README's lines, and the commands in its table, are in the pages, too.
    for line in shell_lines(README) {
        assert!(run.contains(&line), "{line:?} is in no page");
    }
    let table = README.lines().filter(|line| line.starts_with('|'));
    let named = table.flat_map(|line| line.split('`').skip(1).step_by(2));
    for line in named.filter(|line| line.starts_with("tectum ")) {
        let begin = line.trim_end_matches(" ...");
        assert!(
            run.iter().any(|whole| whole.starts_with(begin)),
            "{line:?} is in no page"
        );
    }
    // What is left to other steps of the gate is there.
    for line in OTHERS {
        let is_there = |text: &str| text.contains(line);
        assert!(
            is_there(README) || PAGES.iter().any(|(_, text)| is_there(text)),
            "{line:?}"
        );
    }
}

#[test]
fn design() {
    run_all(&Bench::new(), "design");
}

#[test]
fn calibration() {
    let bench = Bench::new();
    for folder in ["pictures", "l", "r"] {
        boards::write(&bench.path(folder), &boards::session([9, 6]));
    }
    run_all(&bench, "calibration");
}

/// The board that `board --board 8x6 --marker 7` prints, overhead, where both eyes see it.
fn overlap_board() -> String {
    let (yaw, pitch, at) = (-170.0_f64, 55.0, [0.05, 0.0, 0.16]);
    // The marker's middle is 122.5 mm to the left of the board's.
    let (sin, cos) = (yaw.to_radians().sin(), yaw.to_radians().cos());
    let marker = [at[0] + 0.1225 * sin, at[1] - 0.1225 * cos, at[2]];
    let pose = |at: [f64; 3]| {
        format!("pose = {{ position_m = {at:?}, yaw_deg = {yaw:?}, pitch_deg = {pitch:?} }}")
    };
    format!(
        "[[boards]]\ncolumns = 8\nrows = 6\nsquare_mm = 17.0\n{}\n\
         [[markers]]\ndictionary = \"DICT_4X4_50\"\nid = 7\nsize_mm = 68.0\n{}\n",
        pose(at),
        pose(marker)
    )
}

/// Both eyes' pictures as folders `l` and `r`, as files, and in one file.
fn give_pictures(bench: &Bench, shot: &str) {
    for (eye, from) in [("l", "left"), ("r", "right")] {
        fs::create_dir_all(bench.path(eye)).unwrap();
        for to in [format!("{eye}/1.png"), format!("{eye}.png")] {
            fs::copy(bench.path(&format!("{shot}/{from}.png")), bench.path(&to)).unwrap();
        }
    }
    let open = |name: &str| image::open(bench.path(name)).unwrap().into_rgb8();
    let (mut both, right) = (open("l.png"), open("r.png"));
    for (x, y, pixel) in both.enumerate_pixels_mut().filter(|(x, ..)| *x >= 240) {
        *pixel = *right.get_pixel(x, y);
    }
    both.save(bench.path("both.jpg")).unwrap();
}

#[test]
fn registration() {
    let bench = Bench::new();
    fs::write(bench.path("rig.toml"), FISH).unwrap();
    simulate(&bench, "boards", &overlap_board());
    bench.done("simulate rig.toml -o pool --samples 1");
    for line in commands("registration") {
        let of_board = line.contains("--target");
        give_pictures(&bench, if of_board { "boards" } else { "pool" });
        run(&bench, &line);
    }
}

#[test]
fn orientation() {
    let bench = Bench::new();
    // The paper's board, on each side in turn: rows and columns from -2, 35 mm, 160 mm away.
    let rig = include_str!("../../../../tables/rigs/paper-fish.toml");
    fs::write(bench.path("rig.toml"), rig).unwrap();
    fs::write(bench.path("fish.toml"), rig).unwrap();
    bench.done("bake fish.toml -o fish.tct --size 1280x640");
    for (name, side) in [("l", 1.0), ("r", -1.0)] {
        let scene = format!(
            "[[boards]]\ncolumns = 11\nrows = 8\nsquare_mm = 35.0\npose = {{ position_m = \
             [0.105, {:?}, 0.0525], yaw_deg = {:?} }}\n",
            0.16 * side,
            -90.0 * side
        );
        simulate(&bench, name, &scene);
        let eyes = format!("--left {name}/left.png --right {name}/right.png");
        bench.done(&format!("stitch fish.tct {eyes} -o {name}.png"));
    }
    for line in commands("orientation") {
        run(&bench, &line);
        // A whole dive of small eyes.
        if line.starts_with("tectum align") {
            let small = FISH.replace("480, 240", "120, 60");
            let small = small.replace("64.935217", "16.0").replace("119.5", "29.5");
            let small = small
                .replace("359.5", "89.5")
                .replace("\"fish\"", "\"small\"");
            fs::write(bench.path("aligned.toml"), small).unwrap();
            bench.done("bake aligned.toml -o fish.tct --size 320x160 --max-error 1");
        }
    }
}

/// Runs a live view, at an address of its own, until it shows a picture.
fn view(bench: &Bench, line: &str) {
    let line = line.split(" --address").next().unwrap_or_default();
    let viewing = Viewing::start(bench, line.strip_prefix("tectum ").expect("the program"));
    let begun = Instant::now();
    while viewing.frames() == 0 {
        assert!(begun.elapsed() < Duration::from_secs(120), "{line}");
        std::thread::sleep(Duration::from_millis(100));
    }
    viewing.interrupt();
}

#[test]
fn cameras() {
    let bench = Bench::new();
    boards::write(&bench.path("shots"), &boards::session([9, 6])[..5]);
    bench.done("capture x --left shots --right shots --record y4m");
    for (from, to) in [("left", "A"), ("right", "B")] {
        fs::rename(bench.path(&format!("x/{from}.y4m")), bench.path(to)).unwrap();
    }
    let rig = FISH
        .replace("[480, 240]", "[480, 360]")
        .replace("210.0", "150.0");
    let rig = rig
        .replace("64.935217", "130.0")
        .replace("359.5", "239.5")
        .replace("119.5, ", "239.5, ");
    fs::write(bench.path("rig.toml"), rig.replace(", 119.5]", ", 179.5]")).unwrap();
    bench.done("bake rig.toml -o fish.tct --size 320x160 --max-error 0.5");
    for line in commands("cameras") {
        let has_ffmpeg = || Command::new("ffmpeg").arg("-version").output().is_ok();
        if line.starts_with("tectum view") {
            view(&bench, &line);
        } else if line.contains("ffmpeg") && !has_ffmpeg() {
            println!("skipped: no ffmpeg here: {line}");
        } else {
            run(&bench, &line.replace(" --view", " --view 127.0.0.1:0"));
        }
    }
}

#[test]
fn stitching() {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("tables/rigs")).unwrap();
    let rig = include_str!("../../../../tables/rigs/dual-fisheye-210.toml");
    fs::write(bench.path("tables/rigs/dual-fisheye-210.toml"), rig).unwrap();
    let picture = RgbImage::from_fn(3040, 1520, |x, y| {
        image::Rgb([x, y, x ^ y].map(|value| (value / 16) as u8))
    });
    picture.save(bench.path("both-circles.jpg")).unwrap();
    for line in commands("stitching") {
        run(&bench, &line);
        // Every pixel is compared: of a small table, which takes seconds less.
        if line.starts_with("tectum bake") {
            let rig = "tables/rigs/dual-fisheye-210.toml";
            bench.done(&format!(
                "bake {rig} -o pair.tct --size 640x320 --max-error 2"
            ));
        }
    }
}

#[test]
fn lookup() {
    let bench = Bench::new();
    let rig = include_str!("../../../../tables/rigs/paper-fish.toml");
    fs::write(bench.path("rig.toml"), rig).unwrap();
    for eye in ["l.png", "r.png"] {
        image::GrayImage::new(480, 480)
            .save(bench.path(eye))
            .unwrap();
    }
    run_all(&bench, "lookup");
}
