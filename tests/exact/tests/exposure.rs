//! Following exposure, against slow definitions and on pictures whose exposure is known.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use tectum_core::{
    Exposure, Eye, Frame, Gains, Gray8, Meter, Rgb8, Sampler, Stitcher, Tables, Tone,
};
use tectum_exact::{frame, rng, table};
use tectum_tables::MeterPair;
use tectum_tables::builder::{RunData, TableBuilder};

const SIDE: u16 = 40;

/// A table with a metering pair at each pixel of a row of 256, as far as its sources go, and no tone.
fn metered_table(rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut builder = table(rng, [40, 8]);
    builder.tone = Default::default();
    for mesh in builder.mesh.iter_mut().flatten() {
        mesh.source_size_px = [SIDE; 2];
    }
    let pixel = |i: u16| [i % SIDE, i / SIDE];
    builder.meter_pairs = (0..256)
        .map(|i| MeterPair::new(pixel(i), pixel(i)))
        .collect();
    builder.to_bytes().expect("few runs")
}

/// A scene of some contrast, at an exposure: rounded, and clipped as a sensor clips.
fn exposed(scene: &[f64], exposure: f64) -> Vec<u8> {
    let level = |light: &f64| (light * exposure + 0.5).floor().min(255.0) as u8;
    scene.iter().map(level).collect()
}

fn scene(rng: &mut ChaCha8Rng, brightest: f64) -> Vec<f64> {
    let dark = rng.random_range(0.0..brightest / 2.0);
    let pixels = usize::from(SIDE) * usize::from(SIDE);
    (0..pixels)
        .map(|_| rng.random_range(dark..brightest))
        .collect()
}

fn read(meter: &mut Meter, tables: &Tables<'_>, eye: Eye, bytes: &[u8]) {
    let frame = Frame::<Gray8>::new(bytes, SIDE, SIDE, usize::from(SIDE)).expect("its size");
    meter.read(tables, eye, &frame).expect("the table's size");
}

/// Ratios after each of `updates` updates.
fn followed(tables: &Tables<'_>, [left, right]: [&[u8]; 2], rate: u8, updates: usize) -> Vec<f64> {
    let (mut meter, mut exposure) = (Meter::new(), Exposure::new(rate));
    (0..updates)
        .map(|_| {
            read(&mut meter, tables, Eye::Left, left);
            read(&mut meter, tables, Eye::Right, right);
            exposure.update(&meter);
            f64::from(exposure.ratio_q24()) / f64::from(1 << 24)
        })
        .collect()
}

#[test]
fn gains_find_the_true_ratio_without_swinging_or_leaving_their_limits() {
    let bytes = metered_table(&mut rng(0));
    let tables = Tables::parse(&bytes).expect("valid by construction");
    for seed in 0..300 {
        let mut rng = rng(seed);
        let scene = scene(&mut rng, 330.0);
        let ratio = rng.random_range(0.4f64..2.5);
        let [left, right] = [ratio.sqrt(), 1.0 / ratio.sqrt()].map(|e| exposed(&scene, e * 0.7));
        let rate = rng.random_range(0..=5);
        let path = followed(&tables, [&left, &right], rate, 400);
        let known = ratio.clamp(0.5, 2.0);
        let end = path[path.len() - 1];
        // Levels are whole numbers: half a level of the 30 or so that the median lies at is 1.7 %.
        assert!(
            (end / known - 1.0).abs() < 0.017,
            "seed {seed}: {end} for {known}"
        );
        let mut before = 1.0f64;
        for now in path {
            assert!((0.5..=2.0).contains(&now), "seed {seed}: {now}");
            // Always nearer, never past.
            assert!((now - end).abs() <= (before - end).abs(), "seed {seed}");
            assert!((now - end) * (before - end) >= 0.0, "seed {seed}");
            before = now;
        }
    }
}

#[test]
fn half_the_gap_closes_in_the_half_life() {
    let bytes = metered_table(&mut rng(0));
    let tables = Tables::parse(&bytes).expect("valid by construction");
    let scene = scene(&mut rng(1), 120.0);
    let [left, right] = [exposed(&scene, 1.5), exposed(&scene, 1.0)];
    let path = followed(&tables, [&left, &right], Exposure::USUAL_RATE, 200);
    let half = (1.0 + path[199]) / 2.0;
    let half_life = 1 + path.iter().position(|ratio| *ratio >= half).unwrap();
    assert_eq!(half_life, 11);
}

#[test]
fn a_bright_thing_that_one_eye_sees_alone_moves_little() {
    let bytes = metered_table(&mut rng(0));
    let tables = Tables::parse(&bytes).expect("valid by construction");
    let mut rng = rng(3);
    let scene = scene(&mut rng, 200.0);
    let [mut left, right] = [exposed(&scene, 0.9), exposed(&scene, 0.9)];
    // A tenth of the pairs.
    left.iter_mut().step_by(10).for_each(|value| *value = 255);
    let end = followed(&tables, [&left, &right], 0, 1)[0];
    assert!((end - 1.0).abs() < 0.06, "{end}");
}

#[test]
fn what_cannot_be_compared_changes_nothing() {
    let dark = vec![3; usize::from(SIDE) * usize::from(SIDE)];
    let bright = vec![255; dark.len()];
    let usual = exposed(&scene(&mut rng(1), 200.0), 1.0);
    let bytes = metered_table(&mut rng(0));
    let tables = Tables::parse(&bytes).expect("valid by construction");
    let mut exposure = Exposure::new(0);
    for [left, right] in [[&dark, &dark], [&bright, &usual], [&usual, &dark]] {
        let mut meter = Meter::new();
        assert!(!exposure.update(&meter), "nothing read yet");
        read(&mut meter, &tables, Eye::Left, left);
        assert!(!exposure.update(&meter), "one eye read");
        read(&mut meter, &tables, Eye::Right, right);
        assert!(!exposure.update(&meter));
        assert_eq!(exposure, Exposure::new(0));
    }
    assert_eq!(exposure.gains(), Gains::ONE);
}

#[test]
fn the_gains_make_both_eyes_equal() {
    let bytes = metered_table(&mut rng(0));
    let tables = Tables::parse(&bytes).expect("valid by construction");
    for seed in 0..100 {
        let mut rng = rng(seed);
        let scene = scene(&mut rng, 150.0);
        let ratio = rng.random_range(0.7..1.4);
        let [left, right] = [exposed(&scene, 0.9 * ratio), exposed(&scene, 0.9)];
        let mut meter = Meter::new();
        read(&mut meter, &tables, Eye::Left, &left);
        read(&mut meter, &tables, Eye::Right, &right);
        let mut exposure = Exposure::new(0);
        assert!(exposure.update(&meter));
        let gains = exposure.gains();
        let [left_mean, right_mean] =
            [(Eye::Left, &left), (Eye::Right, &right)].map(|(eye, bytes)| {
                let gain = f64::from(gains.q12(eye)) / 4096.0;
                bytes.iter().map(|v| f64::from(*v) * gain).sum::<f64>() / bytes.len() as f64
            });
        // The aim of the whole: no step of more than 1.5 levels where the eyes meet.
        assert!(
            (left_mean - right_mean).abs() < 1.5,
            "seed {seed}: {left_mean} {right_mean}"
        );
    }
}

/// The ratio of `FORMAT.md` by sorting values instead of counting them, in f64.
fn ratio_by_definition(tables: &Tables<'_>, frames: [&[u8]; 2], width: usize) -> Option<f64> {
    let quantiles = |eye: Eye, bytes: &[u8]| -> Vec<f64> {
        let values = tables.meter_pairs().iter().map(|pair| {
            let [x, y] = pair.pixel(eye).map(usize::from);
            let value = bytes[(y * width + x) * 3 + 1];
            let curve = tables.curve(eye, tectum_core::Channel::Green);
            match curve {
                _ if value >= 250 => 255,
                Some(curve) => curve[usize::from(value)],
                None => value,
            }
        });
        let mut values: Vec<u8> = values.collect();
        values.sort_unstable();
        let n = values.len() as f64;
        (1..16)
            .map(|k| {
                let rank = f64::from(k) * n / 16.0;
                let level = values[rank.ceil() as usize - 1];
                let below = values.iter().filter(|v| **v < level).count() as f64;
                let here = values.iter().filter(|v| **v == level).count() as f64;
                let into = ((rank - below) / here * 256.0).floor();
                (f64::from(level) * 256.0 + into - 128.0).max(0.0)
            })
            .collect()
    };
    if tables.meter_pairs().len() < 32 {
        return None;
    }
    let [left, right] = frames;
    let both = quantiles(Eye::Left, left)
        .into_iter()
        .zip(quantiles(Eye::Right, right));
    let trusted = |q: f64| (16.0..=250.0).contains(&(q / 256.0 + 0.5).floor());
    let mut ratios: Vec<f64> = both
        .filter(|(l, r)| trusted(*l) && trusted(*r))
        .map(|(l, r)| (l / r * 4096.0).floor())
        .collect();
    ratios.sort_unstable_by(f64::total_cmp);
    (ratios.len() >= 4).then(|| ratios[ratios.len() / 2] / 4096.0)
}

#[test]
fn the_meter_equals_its_definition() {
    let mut moved = 0;
    for seed in 0..2_000 {
        let mut rng = rng(seed);
        let bytes = table(&mut rng, [24, 3]).to_bytes().expect("few runs");
        let tables = Tables::parse(&bytes).expect("valid by construction");
        let [width, height] = tables.source_size_px(Eye::Left).expect("both eyes");
        let length = usize::from(width) * usize::from(height) * 3;
        let [left, right] = [frame(&mut rng, length), frame(&mut rng, length)];
        let stride = usize::from(width) * 3;
        let mut meter = Meter::new();
        for (eye, bytes) in Eye::BOTH.into_iter().zip([&left, &right]) {
            let frame = Frame::<Rgb8>::new(bytes, width, height, stride).expect("its size");
            meter.read(&tables, eye, &frame).expect("the table's size");
        }
        let mut exposure = Exposure::new(0);
        let came = exposure.update(&meter).then(|| exposure.ratio_q24());
        let expected = ratio_by_definition(&tables, [&left, &right], usize::from(width));
        let expected = expected.map(|ratio| (ratio.clamp(0.5, 2.0) * f64::from(1 << 24)) as i32);
        assert_eq!(came, expected, "seed {seed}");
        moved += usize::from(came.is_some());
    }
    assert!(moved > 200, "only {moved} had enough pairs");
}

/// The gain of `FORMAT.md` in f64, which holds all its integers.
fn gained(chroma: bool, value: u8, gain_q12: u32) -> u8 {
    let (c, g) = (f64::from(value), f64::from(gain_q12) / 4096.0);
    let round = |v: f64| (v + 0.5).floor();
    let gained = if chroma {
        128.0 + round(g * (c - 128.0))
    } else if g >= 1.0 && g * c > 224.0 {
        224.0 + round(31.0 * (g * c - 224.0) / (255.0 * g - 224.0))
    } else if g < 1.0 && c >= 224.0 {
        let rise = ((255.0 - 224.0 * g) * 4096.0 * (c - 224.0) / 31.0).floor() / 4096.0;
        round(224.0 * g + rise)
    } else {
        round(g * c)
    };
    gained.clamp(0.0, 255.0) as u8
}

#[test]
fn gains_act_as_a_table_with_the_same_curves() {
    for seed in 0..200 {
        let mut rng = rng(seed);
        let mut builder = table(&mut rng, [40, 8]);
        let bytes = builder.to_bytes().expect("few runs");
        let tables = Tables::parse(&bytes).expect("valid by construction");
        let gains = random_gains(&mut rng);
        // The same as a table: curve and gain of each channel of each eye.
        for (eye, tone) in Eye::BOTH.into_iter().zip(&mut builder.tone) {
            for (channel, curve) in tone.iter_mut().enumerate() {
                let base = curve.unwrap_or(std::array::from_fn(|v| v as u8));
                let chroma = [1, 2].contains(&channel);
                *curve = Some(base.map(|value| gained(chroma, value, gains.q12(eye))));
            }
        }
        let baked = builder.to_bytes().expect("few runs");
        let baked = Tables::parse(&baked).expect("valid by construction");
        formats::<Gray8>(&mut rng, &tables, &baked, gains, seed);
        formats::<Rgb8>(&mut rng, &tables, &baked, gains, seed);
        formats::<tectum_core::Rgb565>(&mut rng, &tables, &baked, gains, seed);
        formats::<tectum_core::Rgb565Be>(&mut rng, &tables, &baked, gains, seed);
        formats::<tectum_core::Yuyv>(&mut rng, &tables, &baked, gains, seed);
        formats::<tectum_core::Uyvy>(&mut rng, &tables, &baked, gains, seed);
        formats::<tectum_core::Chroma420>(&mut rng, &tables, &baked, gains, seed);
    }
}

/// Gains as exposure finds them in two flat pictures.
fn random_gains(rng: &mut ChaCha8Rng) -> Gains {
    let bytes = metered_table(rng);
    let tables = Tables::parse(&bytes).expect("valid by construction");
    let mut meter = Meter::new();
    for eye in Eye::BOTH {
        let value = rng.random_range(30..=240);
        let flat = vec![value; usize::from(SIDE) * usize::from(SIDE)];
        read(&mut meter, &tables, eye, &flat);
    }
    let mut exposure = Exposure::new(0);
    assert!(exposure.update(&meter));
    exposure.gains()
}

fn formats<F: tectum_core::PixelFormat>(
    rng: &mut impl Rng,
    tables: &Tables<'_>,
    baked: &Tables<'_>,
    gains: Gains,
    seed: u64,
) {
    let [width, height] = tables.source_size_px(Eye::Left).expect("both eyes");
    let stride = usize::from(width) * F::BYTES_PER_PIXEL;
    let bytes = [0, 1].map(|_| {
        let mut bytes = vec![0; stride * usize::from(height).div_ceil(F::ROWS)];
        rng.fill_bytes(&mut bytes);
        bytes
    });
    let [left, right] =
        [0, 1].map(|i| Frame::<F>::new(&bytes[i], width, height, stride).expect("its size"));
    let Ok(stitcher) = Stitcher::new(tables, Sampler::Bilinear) else {
        return;
    };
    let tone = Tone::new(tables, gains);
    let with_gains = stitcher.with_tone(&tone);
    let with_table = Stitcher::new(baked, Sampler::Bilinear).expect("the same width");
    let [mut by_gains, mut by_table, mut by_eyes] =
        [0, 1, 2].map(|_| vec![0; stitcher.row_bytes()]);
    for y in 0..stitcher.rows() {
        with_gains
            .row(&left, &right, y, &mut by_gains)
            .expect("sizes fit");
        with_table
            .row(&left, &right, y, &mut by_table)
            .expect("sizes fit");
        with_gains
            .left_row(&left, y, &mut by_eyes)
            .expect("sizes fit");
        with_gains
            .right_row(&right, y, &mut by_eyes)
            .expect("sizes fit");
        assert_eq!(by_gains, by_table, "seed {seed}, {}, row {y}", F::NAME);
        assert_eq!(by_gains, by_eyes, "seed {seed}, {}, row {y}", F::NAME);
    }
}

#[test]
fn identity_curves_and_gains_of_one_change_no_byte() {
    for seed in 0..200 {
        let mut rng = rng(seed);
        let plain = TableBuilder {
            tone: Default::default(),
            ..table(&mut rng, [40, 8])
        };
        let identity = std::array::from_fn(|v| v as u8);
        let same = TableBuilder {
            tone: [[Some(identity); 6]; 2],
            ..plain.clone()
        };
        let [plain, same] = [plain, same].map(|builder| builder.to_bytes().expect("few runs"));
        let [plain, same] = [&plain, &same].map(|b| Tables::parse(b).expect("valid"));
        for gains in [Gains::ONE, Exposure::new(3).gains()] {
            formats::<Gray8>(&mut rng, &same, &plain, gains, seed);
            formats::<Rgb8>(&mut rng, &same, &plain, gains, seed);
            formats::<tectum_core::Rgb565>(&mut rng, &same, &plain, gains, seed);
            formats::<tectum_core::Rgb565Be>(&mut rng, &same, &plain, gains, seed);
            formats::<tectum_core::Yuyv>(&mut rng, &same, &plain, gains, seed);
            formats::<tectum_core::Uyvy>(&mut rng, &same, &plain, gains, seed);
            formats::<tectum_core::Chroma420>(&mut rng, &same, &plain, gains, seed);
        }
    }
}

#[test]
fn void_has_no_tone() {
    let mut builder = table(&mut rng(5), [16, 4]);
    let [width, height] = builder.output_size_px;
    builder.rows = vec![vec![RunData::Void(width)]; usize::from(height)];
    builder.tone = [[Some([77; 256]); 6]; 2];
    let bytes = builder.to_bytes().expect("few runs");
    let tables = Tables::parse(&bytes).expect("valid by construction");
    let [w, h] = tables.source_size_px(Eye::Left).expect("both eyes");
    let data = vec![9; usize::from(w) * usize::from(h)];
    let frame = Frame::<Gray8>::new(&data, w, h, usize::from(w)).expect("its size");
    let stitcher = Stitcher::new(&tables, Sampler::Nearest).expect("any width");
    let mut row = vec![1; stitcher.row_bytes()];
    stitcher
        .row(&frame, &frame, 0, &mut row)
        .expect("sizes fit");
    assert!(row.iter().all(|value| *value == 0));
}
