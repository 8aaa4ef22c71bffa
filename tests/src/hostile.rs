//! Runs tables that nobody vouches for.

use tectum_bake::{Format, Pair, Pass, stitch};
use tectum_core::{Eye, Lookup, Sampler, TableError, Tables};

/// Parses `bytes`; a table that parses is run in every format and sampler over frames of exactly
/// the size it states, and asked for directions. Nothing of that may panic. Tables with an output
/// over a million pixels are only parsed.
///
/// # Errors
/// What [`Tables::parse`] says.
pub fn parse_and_run(bytes: &[u8]) -> Result<(), TableError> {
    let tables = Tables::parse(bytes)?;
    let size = [tables.output_width_px(), tables.output_height_px()].map(usize::from);
    let [left, right] = Eye::BOTH.map(|eye| tables.source_size_px(eye).unwrap_or_default());
    let pixels = |[w, h]: [u16; 2]| usize::from(w) * usize::from(h);
    if [size[0] * size[1], pixels(left), pixels(right)]
        .iter()
        .any(|n| *n > 1_000_000)
    {
        return Ok(());
    }
    for format in Format::ALL {
        let frame = |size| vec![1; pixels(size) * format.bytes_per_pixel()];
        let (left, right) = (frame(left), frame(right));
        for sampler in [Sampler::Nearest, Sampler::Bilinear] {
            let pair = Pair {
                left: &left,
                right: &right,
            };
            // Formats that do not fit the sizes are refused, which is fine.
            let _ = stitch(&tables, format, sampler, Pass::Both, pair);
        }
    }
    let lookup = Lookup::new(&tables);
    for pixel in [[0, 0], [i32::MIN, i32::MAX], [12_345, 678], [-128, -128]] {
        let direction: tectum_core::Direction =
            lookup.direction_of_pixel(pixel).unwrap_or_default();
        let _ = lookup.pixel_of_direction(direction);
        for eye in Eye::BOTH {
            let _ = lookup.direction_of_eye_pixel(eye, pixel);
        }
    }
    Ok(())
}
