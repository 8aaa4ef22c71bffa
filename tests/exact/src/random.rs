//! Random tables that are valid by construction, and random frames.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_tables::builder::{
    MeshData, OutputMapData, OverlayData, RunData, TableBuilder, ToneData,
};
use tectum_tables::{
    BAND_ROWS, LINE_UNITS, MAX_ROW_RUNS, MeterPair, OverlayLine, Placement, ProjectionKind,
};

/// The generator behind case `seed`, the same on every machine.
pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A frame of random bytes.
pub fn frame(rng: &mut ChaCha8Rng, bytes: usize) -> Vec<u8> {
    let mut frame = vec![0; bytes];
    rng.fill_bytes(&mut frame);
    frame
}

/// A random table of an output up to `max_px`: any step and fraction, meshes as wild as the
/// source allows or pressed against a border, runs down to one pixel, rows of nothing, tone curves,
/// metering pairs and an overlay or none.
pub fn table(rng: &mut ChaCha8Rng, max_px: [u16; 2]) -> TableBuilder {
    let size = max_px.map(|side| rng.random_range(1..=side));
    let source = [rng.random_range(1..=20u16) * 2, rng.random_range(2..=40)];
    TableBuilder {
        output_size_px: size,
        rig_fingerprint: rng.random(),
        mesh: [Some(mesh(rng, size, source)), Some(mesh(rng, size, source))],
        rows: (0..size[1]).map(|_| row(rng, size[0])).collect(),
        output_map: OutputMapData {
            kind: ProjectionKind::Equirect,
            rotation_q30: [1 << 30, 0, 0, 0, 1 << 30, 0, 0, 0, 1 << 30],
            u_q28: [0, 1],
            v_q28: [0, 1],
        },
        rays: [None, None],
        tone: [tone(rng), tone(rng)],
        meter_pairs: pairs(rng, source),
        overlay: rng.random_bool(0.5).then(|| overlay(rng, size)),
        metadata: String::new(),
    }
}

/// No curves for one eye in three, else some of them: wild ones, so that one in the wrong place or
/// order shows.
fn tone(rng: &mut ChaCha8Rng) -> ToneData {
    let likely = [0.0, 0.5, 1.0][rng.random_range(0..3)];
    ToneData::default().map(|_| {
        let there = rng.random_bool(likely);
        there.then(|| std::array::from_fn(|_| rng.random()))
    })
}

fn pairs(rng: &mut ChaCha8Rng, source: [u16; 2]) -> Vec<MeterPair> {
    let pixel = |rng: &mut ChaCha8Rng| source.map(|side| rng.random_range(0..side));
    let count = [0, rng.random_range(1..60)][rng.random_range(0..2)];
    (0..count)
        .map(|_| MeterPair::new(pixel(rng), pixel(rng)))
        .collect()
}

/// Pieces of lines of any slope and glyphs of any size, as many as fit.
fn overlay(rng: &mut ChaCha8Rng, [width, height]: [u16; 2]) -> Vec<u8> {
    let glyph_size_px = [width, height].map(|side| rng.random_range(0..=side.min(16)) as u8);
    let glyphs = (0..rng.random_range(1..3u8))
        .map(|_| (0..glyph_size_px[1]).map(|_| rng.random()).collect())
        .collect::<Vec<Vec<u16>>>();
    let dark = rng.random_range(0..255);
    let bands = (0..height.div_ceil(BAND_ROWS)).map(|band| {
        let lines = (0..rng.random_range(0..5)).map(|_| {
            let mut y = [0, 0].map(|_| rng.random_range(0..=BAND_ROWS as u8 * LINE_UNITS as u8));
            y.sort_unstable();
            // Steep, short, long and beyond the right border.
            let start = rng.random_range(0..=width * LINE_UNITS as u16);
            // Four of them reach over 16 widths at most, as the format asks.
            let most = 300.min(32 * width as i16);
            let end = start.saturating_add_signed(rng.random_range(-most..most));
            OverlayLine::new([start, end], y)
        });
        let lines = lines.collect();
        let top = i32::from(band * BAND_ROWS);
        let lowest = i32::from(height) - i32::from(glyph_size_px[1]) - top;
        let placements = (0..rng.random_range(0..3)).map(|_| {
            let x = rng.random_range(0..=width - u16::from(glyph_size_px[0]));
            let y = rng.random_range((-20).max(-top).min(lowest)..=lowest.min(18));
            Placement::new(x, y as i8, rng.random_range(0..glyphs.len()) as u8)
        });
        (lines, placements.collect())
    });
    let bands = bands.collect();
    let data = OverlayData {
        line_px: rng.random_range(1..=4),
        dark,
        light: rng.random_range(dark + 1..=255),
        glyph_size_px,
        bands,
        glyphs,
    };
    data.to_bytes().expect("few lines")
}

fn mesh(rng: &mut ChaCha8Rng, size: [u16; 2], source: [u16; 2]) -> MeshData {
    let step_log2 = rng.random_range(3..=5);
    let fraction_bits = rng.random_range(4..=8u8);
    let cells = size.map(|side| side.div_ceil(1 << step_log2));
    let origin_px = source.map(|side| rng.random_range(0..side) as i16);
    let style = rng.random_range(0..4);
    let scale = f64::from(1u32 << fraction_bits);
    let along = |rng: &mut ChaCha8Rng, axis: usize| {
        // Positions may be 0 up to just under side - 1, in vertex units.
        let low = -f64::from(origin_px[axis]) * scale;
        let high = low + f64::from(source[axis] - 1) * scale - 1.0;
        let middle = (low + high) / 2.0;
        let value = match style {
            0 => low,
            1 => high,
            // Two passes of overshoot by a quarter each: 1.5625 times the spread fits.
            _ => middle + (high - low) / 2.0 / 1.6 * rng.random_range(-1.0..=1.0),
        };
        value.round().clamp(low, high.floor()) as i16
    };
    let count = cells.iter().map(|n| usize::from(*n) + 3).product();
    MeshData {
        step_log2,
        fraction_bits,
        first_cell: [0, 0],
        cells,
        origin_px,
        source_size_px: source,
        vertices: (0..count).map(|_| [along(rng, 0), along(rng, 1)]).collect(),
    }
}

fn row(rng: &mut ChaCha8Rng, width: u16) -> Vec<RunData> {
    let mut runs = Vec::new();
    let longest = *[1, 3, width, width]
        .get(rng.random_range(0..4))
        .unwrap_or(&width);
    let mut left = width;
    while left > 0 {
        // The last run that a row may have takes the rest.
        let n = match runs.len() + 1 {
            MAX_ROW_RUNS => left,
            _ => rng.random_range(1..=left.min(longest)),
        };
        left -= n;
        runs.push(match rng.random_range(0..5) {
            0 => RunData::Void(n),
            1 => RunData::Left(n),
            2 => RunData::Right(n),
            _ => RunData::Blend(n, rng.random()),
        });
    }
    runs
}
