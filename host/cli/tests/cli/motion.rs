//! A fish in motion: videos of both eyes, stitched with scales of the body and of the world.

use crate::common::Bench;

/// Bytes of the frames of a y4m file, without its header.
fn frames(bench: &Bench, name: &str) -> Vec<Vec<u8>> {
    let bytes = std::fs::read(bench.path(name)).unwrap();
    let header = bytes.iter().position(|b| *b == b'\n').unwrap();
    // 4:2:2, a "FRAME" line each.
    let size = b"FRAME\n".len() + 2 * 160 * 80;
    let frames = bytes[header + 1..].chunks(size);
    frames.map(<[u8]>::to_vec).collect()
}

#[test]
fn scales_of_the_world_stay_level_when_the_body_does_not() {
    let bench = Bench::with_table();
    let made =
        bench.json("simulate rig.toml -o roll --motion roll --seconds 1 --fps 3 --samples 1");
    assert_eq!(made["frames"], 3);
    let stitch = "stitch fish.tct --live --left roll/left.y4m --right roll/right.y4m";
    let out = [
        ("plain.y4m", ""),
        ("body.y4m", "--scales=30"),
        ("world.y4m", "--scales=30 --attitude roll/attitude.csv"),
    ];
    let [plain, body, world] = out.map(|(name, more)| {
        bench.done(&format!("{stitch} -o {name} {more}"));
        frames(&bench, name)
    });
    assert_eq!([plain.len(), body.len(), world.len()], [3; 3]);
    // At first the body is as the world is; half a turn later it is upside down.
    assert!(body[0] == world[0], "the body is not turned yet");
    assert!(plain[0] != body[0] && body[1] != world[1]);
}

#[test]
fn attitudes_must_be_there_for_the_time_of_every_frame() {
    let bench = Bench::with_table();
    bench.done("simulate rig.toml -o swim --motion swim --seconds 1 --fps 2 --samples 1");
    let stitch = "stitch fish.tct --live --left swim/left.y4m --right swim/right.y4m";
    let csv = std::fs::read_to_string(bench.path("swim/attitude.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().collect();
    let write = |rows: &[&str]| std::fs::write(bench.path("a.csv"), rows.join("\n")).unwrap();
    write(&rows[..2]);
    let output = bench.run(&format!("{stitch} -o out.y4m --scales --attitude a.csv"));
    let says = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && says.contains("no row for 0.500 s"),
        "{says}"
    );
    write(&[rows[0], rows[2]]);
    let says = bench.refused(1, &format!("{stitch} -o x.y4m --scales --attitude a.csv"));
    assert!(says.contains("no row for 0.000 s"), "{says}");
    // What is no number is no angle.
    let broken = rows[2].replacen("0.5", "NaN", 1);
    write(&[rows[0], rows[1], &broken]);
    let says = bench.refused(1, &format!("{stitch} -o x.y4m --scales --attitude a.csv"));
    assert!(says.contains("needed are numbers"), "{says}");
    bench.refused(2, &format!("{stitch} -o x.y4m --attitude a.csv"));
}
