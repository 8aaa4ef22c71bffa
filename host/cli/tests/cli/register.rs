//! `tectum register`: from pictures to a rig that bakes.

use crate::common::Bench;

#[test]
fn colours_and_seam_of_the_pool_are_found_baked_and_verified() {
    let bench = Bench::with_pictures();
    let found = bench.json(
        "register rig.toml --left left.png --right right.png --keep-poses -o eyes.toml --width 512 \
         --report eyes.html",
    );
    assert_eq!(found["pairs"], 1);
    assert!(found["inliers"].is_null() && found["rms_deg"].is_null());
    let [before, after] = ["ssim_before", "ssim"].map(|key| found["seam"][key].as_f64().unwrap());
    assert!(
        after >= before,
        "alignment never makes the seam worse: {before} {after}"
    );
    // With the defaults of `bake` there is a table, and a small one.
    let [bytes, before] =
        ["bytes", "bytes_before"].map(|key| found["table"][key].as_f64().unwrap());
    assert!(bytes <= 1.3 * before, "{}", found["table"]);
    // What is nearer than 2 m is cut, what is farther doubled: 60 mm (1/d - 1/2 m).
    let ahead = found["ahead"].as_array().unwrap();
    assert_eq!(ahead.len(), 6);
    let law_deg = (0.06f64 * (1.0 / 0.5 - 1.0 / 2.0)).to_degrees();
    let half_a_metre = ahead[1]["lost_deg"].as_f64().unwrap();
    assert!((half_a_metre - law_deg).abs() < 0.02 * law_deg, "{ahead:?}");
    assert!(bench.path("eyes.html").is_file());
    let picture = |rig: &str, part: &str| {
        let start = format!("{rig}-{part}-");
        let of_part: Vec<String> = bench
            .files()
            .into_iter()
            .filter(|f| f.starts_with(&start))
            .collect();
        assert_eq!(of_part.len(), 1, "{start}: {of_part:?}");
        bench.path(&of_part[0])
    };
    bench.done("bake eyes.toml -o eyes.tct --size 160x80 --max-error 0.4");
    let verified = bench.json("verify eyes.tct --rig eyes.toml --left left.png --right right.png");
    assert_eq!(verified["mismatches"], 0);
    // Nothing of an earlier registration is measured: the second finds what the first did.
    bench.done(
        "register eyes.toml --left left.png --right right.png --keep-poses -o again.toml --width 512",
    );
    for part in ["seam", "tone"] {
        let [first, second] =
            ["eyes", "again"].map(|rig| std::fs::read(picture(rig, part)).unwrap());
        assert!(first == second, "{part}");
    }
    // What the rig names must be what it was registered with.
    std::fs::copy(bench.path("left.png"), picture("eyes", "seam")).unwrap();
    let refused = bench.refused(1, "bake eyes.toml -o eyes.tct --size 160x80");
    assert!(
        refused.contains("eyes-seam-") && refused.contains("register again"),
        "{refused}"
    );
}

#[test]
fn the_stitch_distance_is_the_rigs_the_pictures_or_the_one_asked_for() {
    let bench = Bench::with_pictures();
    let register = "register rig.toml --left left.png --right right.png --keep-poses --no-seam \
                    --tone none -o eyes.toml";
    let kept = bench.json(register);
    let own = kept["distance"]["of_rig_m"].as_f64().unwrap();
    assert_eq!(kept["distance"]["metres"].as_f64(), Some(own));
    let asked = bench.json(&format!("{register} --distance 1.25"));
    assert_eq!(asked["distance"]["metres"], 1.25);
    let rig = std::fs::read_to_string(bench.path("eyes.toml")).unwrap();
    assert!(rig.contains("stitch_distance_m = 1.25"), "{rig}");
    let auto = bench.json(&format!("{register} --distance auto"));
    let found = &auto["distance"]["pictures"];
    // What is taken is what was found, or nothing was found.
    let clear = found["is_clear"].as_bool().unwrap();
    let expected = if clear {
        &found["distance_m"]
    } else {
        &kept["distance"]["metres"]
    };
    assert_eq!(&auto["distance"]["metres"], expected, "{auto}");
    let refused = bench.refused(2, &format!("{register} --distance near"));
    assert!(refused.contains("metres such as 1.5"), "{refused}");
    let refused = bench.refused(1, &format!("{register} --distance 0.001"));
    assert!(refused.contains("stitch_distance_m"), "{refused}");
}

#[test]
fn wrong_pictures_are_refused_in_a_sentence() {
    let bench = Bench::with_pictures();
    for (arguments, part) in [
        ("--matcher board", "--target FILE.json"),
        (
            "--board 8x6 --square-mm 30",
            "no pairs of points: pair 1: the right eye sees no such board",
        ),
        ("--target none.json", "none.json"),
        ("--matcher superpoint", "superpoint"),
    ] {
        let command =
            format!("register rig.toml --left left.png --right right.png -o eyes.toml {arguments}");
        let refused = bench.refused(1, &command);
        assert!(refused.contains(part), "{arguments}: {refused}");
        assert!(!bench.path("eyes.toml").exists());
    }
    let refused = bench.refused(
        1,
        "register rig.toml --left left.png --right none.png -o eyes.toml",
    );
    assert!(refused.contains("none.png"), "{refused}");
}

#[test]
fn the_papers_planar_picture_is_there_for_comparison() {
    let bench = Bench::with_pictures();
    let found = bench.json("stitch rig.toml --paper --left left.png --right right.png -o p.png");
    assert!(bench.path("p.png").is_file());
    // A plane holds a part of the overlap of two 210 degree eyes, never all of it.
    let held = found["overlap_held"].as_f64().unwrap();
    assert!((0.15..1.0).contains(&held), "{held}");
}

#[test]
fn scenes_beside_and_where_to_look_are_taken_or_refused() {
    let bench = Bench::with_pictures();
    let register = "register rig.toml --left left.png --right right.png --keep-poses --no-seam \
                    --tone none -o eyes.toml";
    let kept = bench.json(&format!(
        "{register} --scene-left left.png --scene-right right.png --distance auto --toward -30..30"
    ));
    assert_eq!(kept["pairs"], 1);
    for (more, part) in [
        ("--scene-left left.png", "--scene-right"),
        ("--toward 30..-30", "-30..30"),
        ("--size 0x3", "640x320"),
    ] {
        let refused = bench.refused(2, &format!("{register} {more}"));
        assert!(refused.contains(part), "{more}: {refused}");
    }
    let refused = bench.refused(1, &format!("{register} --distance boards"));
    assert!(refused.contains("--target"), "{refused}");
}

/// Registers real pairs and bakes them with the defaults: all succeed, small.
#[test]
#[ignore = "campaign registration: minutes of real pictures"]
fn real_pairs_are_baked_small() {
    let repository = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = repository.join("../shared/data");
    if !data.is_dir() {
        println!("skipped: real pictures are not beside this checkout");
        return;
    }
    let sweepnet = |eyes: [u8; 2]| {
        let [left, right] =
            eyes.map(|eye| data.join(format!("rig220-sweepnet/cam{eye}/00001.png")));
        format!("--left {} --right {}", left.display(), right.display())
    };
    let one = |file: &str| format!("--picture {}", data.join(file).display());
    let gear = one("dual-fisheye-gear360/extract.png");
    for (rig, pictures, ways) in [
        (
            "dual-fisheye-210",
            one("dual-fisheye-210/fishcam1.jpg"),
            &["--keep-poses"][..],
        ),
        (
            "dual-fisheye-210",
            one("dual-fisheye-210/fishcam2.jpg"),
            &["--keep-poses"],
        ),
        ("gear360", gear, &["--keep-poses", ""]),
        (
            "sweepnet-1-3",
            sweepnet([1, 3]),
            &["--keep-poses", "", "--board 12x10 --square-mm 60"],
        ),
        ("sweepnet-2-4", sweepnet([4, 2]), &["--keep-poses", ""]),
    ] {
        let bench = Bench::new();
        let rig_file = repository.join("tables/rigs").join(format!("{rig}.toml"));
        for way in ways {
            let found = bench.json(&format!(
                "register {} {pictures} {way} -o eyes.toml",
                rig_file.display()
            ));
            let quality = &found["seam"]["quality"];
            println!(
                "{rig} {way}: own SSIM {:.3}, ghosts {:.3}, step {:+.2}, bend {:.2} degrees",
                quality["own_ssim"].as_f64().unwrap(),
                quality["ghost"].as_f64().unwrap(),
                quality["edge_excess"].as_f64().unwrap(),
                found["alignment"]["greatest_deg"].as_f64().unwrap(),
            );
            assert!(quality["ghost"].as_f64().unwrap() <= 0.01);
            for size in ["640x320", "1280x640", "2048x1024"] {
                let bytes = |rig: &str| {
                    let baked = bench.json(&format!("bake {rig} -o t.tct --size {size}"));
                    baked["bytes"]["total"].as_f64().unwrap()
                };
                let times = bytes("eyes.toml") / bytes(&rig_file.display().to_string());
                println!("    {size}: {times:.2} times the bytes");
                assert!(times <= 1.3, "{rig} {way} {size}");
            }
        }
    }
}
