//! A rig's tone, baked, and metering pairs.

use tectum_bake::{BakeOptions, Baked, Pair, bake, verify};
use tectum_core::{Channel, Eye, Tables};
use tectum_optics::convention::angle_between;
use tectum_optics::{Projection, RgbCurves, Rig, Stitching};

fn fish(right: bool) -> Rig {
    let eye = "size_px = [240, 240]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
               focal_px_per_rad = 64.9, centre_px = [119.5, 119.5] }\n";
    let right = if right {
        format!("[right]\n{eye}")
    } else {
        String::new()
    };
    let text = format!(
        "name = 'fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}{right}"
    );
    Rig::from_toml(&text, "fish").expect("a sound rig")
}

fn baked(rig: &Rig) -> Baked {
    let options = BakeOptions {
        output: Projection::Equirect.output_map([320, 160]).unwrap(),
        max_error_px: 0.1,
        feather_rad: 0.1,
    };
    bake(rig, &options).unwrap()
}

fn gamma(exponents: [f64; 3]) -> RgbCurves {
    exponents.map(|exponent| {
        std::array::from_fn(|v| (255.0 * (v as f64 / 255.0).powf(exponent) + 0.5) as u8)
    })
}

#[test]
fn a_rigs_tone_is_baked_and_verified() {
    let mut rig = fish(true);
    rig.stitching = Some(Stitching {
        tone: Some([gamma([0.8, 0.9, 1.1]), gamma([1.0, 1.1, 1.0])]),
        ..Stitching::default()
    });
    let baked = baked(&rig);
    let tables = Tables::parse(&baked.bytes).unwrap();
    // Of the right eye, red and blue stay as they are: two curves less.
    assert_eq!(baked.report.bytes.tone, 4 + (6 + 4) * 256);
    assert_eq!(tables.tone_bytes(), baked.report.bytes.tone);
    assert!(tables.curve(Eye::Right, Channel::Red).is_none());
    assert_eq!(
        tables.curve(Eye::Left, Channel::Blue),
        Some(&gamma([1.1; 3])[0])
    );
    assert!(baked.report.tone_error.is_some());

    let noise = |k: usize| -> Vec<u8> {
        (0..240 * 240 * 3)
            .map(|i| ((i * i * k) >> 7) as u8)
            .collect()
    };
    let [left, right] = [noise(31), noise(57)];
    let pair = Pair {
        left: &left,
        right: &right,
    };
    let same = verify(&tables, Some(&rig), pair).unwrap();
    assert_eq!(same.mismatches, 0);
    assert_eq!(same.formats.len(), 6);
    assert!(
        same.rounding_error_lsb <= 0.5,
        "{}",
        same.rounding_error_lsb
    );
}

#[test]
fn metering_pairs_see_the_same_and_are_spread_over_the_overlap() {
    let mut rig = fish(true);
    rig.stitching = Some(Stitching::default());
    let baked = baked(&rig);
    let tables = Tables::parse(&baked.bytes).unwrap();
    let pairs = tables.meter_pairs();
    assert!((230..=280).contains(&pairs.len()), "{}", pairs.len());
    assert_eq!(baked.report.bytes.meter, 8 * pairs.len());
    let direction = |eye: &Option<tectum_optics::RigEye>, [x, y]: [u16; 2]| {
        let pixel = [f64::from(x), f64::from(y)];
        eye.as_ref().unwrap().direction_of(pixel, 2.0).unwrap()
    };
    // At the rim, half a pixel each way in each eye is 0.71 / 64.9 rad along and, round the axis,
    // 1.9 times that (theta / sin theta is less than 1 / 0.52): both eyes are off by less than 2 px.
    let close = 2.0 / 64.9;
    let mut seen = [0; 2];
    for pair in pairs {
        let left = direction(&rig.left, pair.pixel(Eye::Left));
        let right = direction(&rig.right, pair.pixel(Eye::Right));
        assert!(angle_between(&left, &right) < close);
        seen[usize::from(left.x < 0.0)] += 1;
    }
    // The eyes of the paper's fish also meet behind it.
    assert!(seen.iter().all(|n| *n > 20), "{seen:?}");
}

#[test]
fn nothing_is_metered_without_stitching_or_with_one_eye() {
    assert_eq!(baked(&fish(true)).report.bytes.meter, 0);
    let mut one_eye = fish(false);
    one_eye.stitching = Some(Stitching::default());
    assert_eq!(baked(&one_eye).report.bytes.meter, 0);
}
