use super::*;
use crate::Rig;

const RIG: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
    [mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n\
    [left]\nsize_px = [480, 480]\nfield_deg = 160.0\n\
    lens = { model = \"equidistant\", focal_px_per_rad = 129.9, centre_px = [239.5, 239.5] }\n";

fn png(picture: DynamicImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// A folder with a rig whose section has the given lines.
fn folder(name: &str, files: &[(&str, &[u8])], section: &str) -> tempfile::TempDir {
    let folder = tempfile::Builder::new().prefix(name).tempdir().unwrap();
    for (file, bytes) in files {
        std::fs::write(folder.path().join(file), bytes).unwrap();
    }
    let text = format!("{RIG}[stitching]\n{section}");
    std::fs::write(folder.path().join("rig.toml"), text).unwrap();
    folder
}

fn entry(key: &str, file: &str, bytes: &[u8]) -> String {
    format!(
        "{key} = {{ file = \"{file}\", sha256 = \"{}\" }}\n",
        hex(bytes)
    )
}

#[test]
fn a_rig_reads_its_seam_tone_and_warp() {
    let shares = (0..16 * 8).map(|i| if i % 16 < 8 { 255 } else { 0 });
    let seam = image::GrayImage::from_raw(16, 8, shares.collect()).unwrap();
    let tone = image::RgbImage::from_fn(256, 2, |value, eye| {
        image::Rgb([value as u8, (255 - value) as u8, eye as u8])
    });
    let warp = image::ImageBuffer::from_fn(16, 8, |_, _| image::Rgba([32868u16, 32768, 0, 65535]));
    let files = [
        ("s.png", png(seam.into())),
        ("t.png", png(tone.into())),
        ("w.png", png(DynamicImage::ImageRgba16(warp))),
    ];
    let keys = ["seam", "tone", "warp"].iter().zip(&files);
    let section: String = keys
        .map(|(key, (file, bytes))| entry(key, file, bytes))
        .collect();
    let listed: Vec<(&str, &[u8])> = files.iter().map(|(f, b)| (*f, b.as_slice())).collect();
    let folder = folder("stitching", &listed, &(section + "warp_step_deg = 0.001\n"));
    let rig = Rig::load(&folder.path().join("rig.toml")).unwrap();
    let stitching = rig.stitching.as_ref().unwrap();

    // The left half of the picture is yaw 180 to 0.
    let share = |yaw_deg: f64| {
        let seam = stitching.seam.as_ref().unwrap();
        seam.left_share(&direction(yaw_deg.to_radians(), 0.1))
    };
    assert_eq!((share(90.0), share(-90.0)), (1.0, 0.0));
    // Half-way between the middle columns, and across the picture's edge.
    assert!((share(0.0) - 0.5).abs() < 1e-9 && (share(180.0) - 0.5).abs() < 1e-9);

    let [left, right] = stitching.tone.unwrap();
    assert_eq!((left[0][7], left[1][7], right[2][7]), (7, 248, 1));

    let warp = stitching.warp.as_ref().unwrap();
    let ahead = direction(0.2, 0.3);
    let (yaw, pitch) = yaw_pitch(&warp.bent(0, &ahead));
    // A constant raster is constant between its samples.
    assert!((yaw - 0.2 - 0.1f64.to_radians()).abs() < 1e-12 && (pitch - 0.3).abs() < 1e-12);
    let (yaw, _) = yaw_pitch(&warp.bent(1, &ahead));
    assert!((yaw - 0.2 + 32.768f64.to_radians()).abs() < 1e-9);

    // The files' hashes are part of the rig's identity.
    let plain = Rig::from_toml(RIG, "plain").unwrap();
    assert_ne!(plain.fingerprint(), rig.fingerprint());
}

#[test]
fn other_files_are_refused() {
    let gray = png(image::GrayImage::new(16, 8).into());
    let small = png(image::GrayImage::new(2, 2).into());
    for (section, part) in [
        (entry("seam", "s.png", b"other"), "register again"),
        (entry("seam", "none.png", &gray), "none.png: cannot be read"),
        (entry("tone", "s.png", &gray), "8-bit RGB"),
        (entry("warp", "s.png", &gray), "16-bit RGBA"),
        (entry("seam", "2.png", &small), "2x2"),
        (entry("seam", "x.png", b"no picture"), "x.png"),
        ("seem = 3\n".to_owned(), "seem"),
    ] {
        let files: [(&str, &[u8]); 3] = [
            ("s.png", &gray),
            ("2.png", &small),
            ("x.png", b"no picture"),
        ];
        let folder = folder("refused", &files, &section);
        let error = Rig::load(&folder.path().join("rig.toml")).unwrap_err();
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
}
