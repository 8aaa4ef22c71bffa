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
    for file in ["eyes-seam.png", "eyes-tone.png", "eyes.html"] {
        assert!(bench.path(file).is_file(), "{file}");
    }
    bench.done("bake eyes.toml -o eyes.tct --size 160x80 --max-error 0.4");
    let verified = bench.json("verify eyes.tct --rig eyes.toml --left left.png --right right.png");
    assert_eq!(verified["mismatches"], 0);
    // Nothing of an earlier registration is measured: the second finds what the first did.
    bench.done(
        "register eyes.toml --left left.png --right right.png --keep-poses -o again.toml --width 512",
    );
    for part in ["seam", "tone"] {
        let [first, second] = ["eyes", "again"]
            .map(|rig| std::fs::read(bench.path(&format!("{rig}-{part}.png"))).unwrap());
        assert!(first == second, "{part}");
    }
    // What the rig names must be what it was registered with.
    std::fs::copy(bench.path("left.png"), bench.path("eyes-seam.png")).unwrap();
    let refused = bench.refused(1, "bake eyes.toml -o eyes.tct --size 160x80");
    assert!(
        refused.contains("eyes-seam.png") && refused.contains("register again"),
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
        ("--board 8x6 --square-mm 30", "pairs"),
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
