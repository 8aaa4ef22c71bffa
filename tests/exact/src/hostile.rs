//! Runs tables that nobody vouches for. Needs the core alone: the fuzz target builds this file, too.

use tectum_core::{
    AngularSize, Chroma420, Exposure, Eye, Frame, Gray8, Lookup, Meter, Painter, PixelBox,
    PixelFormat, Rgb8, Rgb565, Rgb565Be, Sampler, Stitcher, TableError, Tables, Targets, Tone,
    Uyvy, View, Yuyv,
};

/// Parses `bytes`; a table that parses is run in every format and sampler over frames of exactly
/// the size it states, drawn over, and asked for directions and targets. Nothing of that may panic. Tables with an output
/// or a source over a million pixels are only parsed.
///
/// # Errors
/// What [`Tables::parse`] says.
pub fn parse_and_run(bytes: &[u8]) -> Result<(), TableError> {
    let tables = Tables::parse(bytes)?;
    let output = [tables.output_width_px(), tables.output_height_px()];
    // An eye that the table does not show may be any frame.
    let sources = Eye::BOTH.map(|eye| tables.source_size_px(eye).unwrap_or([2, 2]));
    let [left, right] = sources;
    if [output, left, right]
        .into_iter()
        .any(|size| pixels(size) > 1_000_000)
    {
        return Ok(());
    }
    run::<Gray8>(&tables, sources);
    run::<Rgb565>(&tables, sources);
    run::<Rgb565Be>(&tables, sources);
    run::<Yuyv>(&tables, sources);
    run::<Uyvy>(&tables, sources);
    run::<Chroma420>(&tables, sources);
    run::<Rgb8>(&tables, sources);
    let lookup = Lookup::new(&tables);
    for pixel in [[0, 0], [i32::MIN, i32::MAX], [12_345, 678], [-128, -128]] {
        let direction = lookup.direction_of_pixel(pixel).unwrap_or_default();
        let _ = lookup.pixel_of_direction(direction);
        for eye in Eye::BOTH {
            let _ = lookup.direction_of_eye_pixel(eye, pixel);
            let _ = lookup.eye_pixel_of_direction(eye, direction);
        }
    }
    targets(&tables);
    Ok(())
}

/// Boxes as they come and as they should not.
fn targets(tables: &Tables<'_>) {
    let mut targets = Targets::<8>::new(tables);
    for [x, y, width, height] in [
        [0, 0, 1, 1],
        [3, 2, 5, 4],
        [0, 0, 0, 7],
        [u16::MAX; 4],
        [0, 0, u16::MAX, u16::MAX],
    ] {
        let pixels = PixelBox {
            x,
            y,
            width,
            height,
        };
        for view in [View::Eye(Eye::Left), View::Eye(Eye::Right), View::Stitched] {
            let _ = targets.add(view, pixels);
        }
    }
    let _ = targets.merged(AngularSize(1000));
    let _ = Targets::<8>::parallax(tables, 0.0);
}

fn pixels([width, height]: [u16; 2]) -> usize {
    usize::from(width) * usize::from(height)
}

/// Stitches a picture both ways, the second time with what metering gives. Formats that do not fit the sizes are refused, which is fine.
fn run<F: PixelFormat>(tables: &Tables<'_>, sources: [[u16; 2]; 2]) {
    let data = sources.map(|size| {
        let rows = usize::from(size[1]).div_ceil(F::ROWS);
        vec![1; usize::from(size[0]) * F::BYTES_PER_PIXEL * rows]
    });
    let frame = |i: usize| {
        let [width, height] = sources[i];
        Frame::<F>::new(
            &data[i],
            width,
            height,
            usize::from(width) * F::BYTES_PER_PIXEL,
        )
    };
    let (Ok(left), Ok(right)) = (frame(0), frame(1)) else {
        return;
    };
    let (mut meter, mut exposure) = (Meter::new(), Exposure::new(0));
    for (eye, frame) in Eye::BOTH.into_iter().zip([&left, &right]) {
        let _ = meter.read(tables, eye, frame);
    }
    exposure.update(&meter);
    let tone = Tone::new(tables, exposure.gains());
    let painter = tables.overlay().map(Painter::<F>::new);
    for sampler in [Sampler::Nearest, Sampler::Bilinear] {
        let Ok(stitcher) = Stitcher::new(tables, sampler) else {
            return;
        };
        let mut row = vec![0; stitcher.row_bytes()];
        for y in 0..stitcher.rows() {
            let _ = stitcher.row(&left, &right, y, &mut row);
            let stitcher = stitcher.with_tone(&tone);
            let _ = stitcher.left_row(&left, y, &mut row);
            let _ = stitcher.right_row(&right, y, &mut row);
            let _ = painter.map(|painter| painter.row(y, &mut row));
        }
    }
}
