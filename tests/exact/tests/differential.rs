//! The core against the quantised reference: every byte, over every way to run.

use tectum_bake::reference::{overlay, position_q8, quantised};
use tectum_bake::{Format, Pair, Pass, draw_overlay, stitch};
use tectum_core::{Chroma420, Eye, Gray8, Nv12, Sampler, Stitcher, Tables};
use tectum_exact::{cases, frame, rng, table};

/// Stitches random frames with random table `seed` in every format given and compares bytes.
fn core_equals_reference(seed: u64, max_px: [u16; 2], formats: &[Format]) {
    let mut rng = rng(seed);
    let bytes = table(&mut rng, max_px).to_bytes().expect("few runs");
    let tables = Tables::parse(&bytes).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    let source_px = tables
        .source_size_px(Eye::Left)
        .expect("both eyes")
        .map(usize::from);
    for format in formats
        .iter()
        .filter(|f| f.holds_width(tables.output_width_px()))
    {
        let length = format.picture_bytes(source_px);
        let [left, right] = [frame(&mut rng, length), frame(&mut rng, length)];
        let pair = Pair {
            left: &left,
            right: &right,
        };
        for sampler in [Sampler::Nearest, Sampler::Bilinear] {
            let expected = quantised::stitch(&tables, *format, sampler, pair);
            for pass in [Pass::Both, Pass::OneEyeAtATime] {
                let core = stitch(&tables, *format, sampler, pass, pair).expect("sizes fit");
                assert!(
                    core == expected,
                    "seed {seed}, {format:?}, {sampler:?}, {pass:?}"
                );
            }
            if let Some(overlay) = tables.overlay() {
                let drawn = overlay::draw(&overlay, *format, &expected);
                let mut core = expected;
                draw_overlay(&overlay, *format, &mut core).expect("its size");
                assert!(core == drawn, "seed {seed}, {format:?}: the overlay");
            }
        }
    }
}

#[test]
fn thousands_of_small_tables() {
    for seed in 0..cases(20_000) {
        core_equals_reference(seed, [24, 3], &[Format::Gray8]);
    }
}

#[test]
#[ignore = "campaign exact: a minute"]
fn hundred_thousand_small_tables() {
    for seed in 0..100_000 {
        core_equals_reference(seed, [24, 3], &[Format::Gray8]);
    }
}

#[test]
fn all_formats_over_odd_sizes() {
    for seed in 0..cases(2_000) {
        core_equals_reference(seed, [70, 9], &Format::ALL);
    }
}

/// Both planes of NV12 out of one buffer whose rows are `padding` bytes longer than the pixels.
fn nv12_with_padding(tables: &Tables<'_>, pair: Pair<'_>, padding: usize) -> Vec<u8> {
    let [width, height] = tables.source_size_px(Eye::Left).expect("both eyes");
    let stride = usize::from(width) + padding;
    let padded = [pair.left, pair.right].map(|packed| {
        let rows = packed.chunks_exact(width.into());
        let mut bytes: Vec<u8> = rows
            .flat_map(|row| row.iter().copied().chain(vec![0xA5; padding]))
            .collect();
        // Cameras may leave out what follows the last row.
        bytes.truncate(bytes.len() - padding);
        bytes
    });
    let [left, right] = padded
        .each_ref()
        .map(|bytes| Nv12::new(bytes, width, height, stride).expect("as long as it needs to be"));
    let luma = Stitcher::<Gray8>::new(tables, Sampler::Bilinear).expect("even width");
    let chroma = Stitcher::<Chroma420>::new(tables, Sampler::Bilinear).expect("even width");
    let size_px = [tables.output_width_px(), tables.output_height_px()].map(usize::from);
    let mut out = vec![0; Format::Nv12.picture_bytes(size_px)];
    let (above, below) = out.split_at_mut(size_px[0] * size_px[1]);
    let row_bytes = luma.row_bytes();
    (luma.frame(&left.luma, &right.luma, above, row_bytes)).expect("sizes fit");
    (chroma.frame(&left.chroma, &right.chroma, below, row_bytes)).expect("sizes fit");
    out
}

#[test]
fn padding_is_never_part_of_a_picture_in_nv12() {
    for seed in 0..cases(500) {
        let mut rng = rng(seed);
        let bytes = table(&mut rng, [70, 9]).to_bytes().expect("few runs");
        let tables = Tables::parse(&bytes).expect("valid by construction");
        let source_px = tables.source_size_px(Eye::Left).expect("both eyes");
        if !Format::Nv12.holds_width(tables.output_width_px()) {
            continue;
        }
        let length = Format::Nv12.picture_bytes(source_px.map(usize::from));
        let [left, right] = [frame(&mut rng, length), frame(&mut rng, length)];
        let pair = Pair {
            left: &left,
            right: &right,
        };
        let packed = quantised::stitch(&tables, Format::Nv12, Sampler::Bilinear, pair);
        for padding in [0, 1, 64] {
            let padded = nv12_with_padding(&tables, pair, padding);
            assert!(padded == packed, "seed {seed}, {padding} bytes of padding");
        }
    }
}

#[test]
fn tall_and_wide_tables() {
    for seed in 0..30 {
        core_equals_reference(seed, [700, 4], &Format::ALL);
        core_equals_reference(seed, [5, 500], &Format::ALL);
    }
}

#[test]
fn segments_start_anywhere_in_a_cell() {
    for seed in 0..cases(300) {
        let mut rng = rng(seed);
        let bytes = table(&mut rng, [70, 40]).to_bytes().expect("few runs");
        let tables = Tables::parse(&bytes).expect("valid by construction");
        let mesh = tables.mesh(Eye::Left).expect("both eyes");
        let (width, height) = (tables.output_width_px(), tables.output_height_px());
        for (y, start) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut x = usize::from(start);
            let len = (u32::from(width) - u32::from(start)).min(9);
            for mut segment in mesh.segments(y, u32::from(start), len) {
                for _ in 0..segment.len {
                    let position = [segment.x.position_q8(), segment.y.position_q8()];
                    let expected = position_q8(&tables, Eye::Left, x, usize::from(y));
                    assert_eq!(Some(position), expected, "seed {seed}, pixel ({x}, {y})");
                    segment.step();
                    x += 1;
                }
            }
            assert_eq!(x, usize::from(start) + len as usize);
        }
    }
}

#[test]
fn a_constant_picture_stays_constant() {
    for seed in 0..cases(500) {
        let mut rng = rng(seed);
        let mut builder = table(&mut rng, [40, 8]);
        // A constant tone is as good as none.
        let constant = [(seed % 256) as u8; 256];
        builder.tone = [[None; 6], [Some(constant); 6]];
        let bytes = builder.to_bytes().expect("few runs");
        let tables = Tables::parse(&bytes).expect("valid by construction");
        let [w, h] = tables
            .source_size_px(Eye::Left)
            .expect("both eyes")
            .map(usize::from);
        let value = (seed % 256) as u8;
        let flat = vec![value; w * h];
        let pair = Pair {
            left: &flat,
            right: &flat,
        };
        let out = stitch(&tables, Format::Gray8, Sampler::Bilinear, Pass::Both, pair).unwrap();
        let background = out.iter().filter(|v| **v != value).count();
        let void: u32 = (0..tables.output_height_px())
            .flat_map(|y| tables.runs(y))
            .filter(|run| run.kind == tectum_tables::RunKind::Void)
            .map(|run| run.len)
            .sum();
        let expected = if value == 0 { 0 } else { void as usize };
        assert_eq!(background, expected, "seed {seed}");
    }
}
