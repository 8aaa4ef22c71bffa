//! Whole pictures on several threads.

use rayon::prelude::*;
use tectum_core::{Frame, PixelFormat, Sampler, StitchError, Stitcher, Tables};

/// Rows to a band: some 4 to 16 bands a thread even out rows of different cost, and starting a
/// band costs little beside stitching it.
const BAND_ROWS: usize = 16;

/// Stitches into `out` (rows tightly packed), bands of rows spread over the threads of the
/// present rayon pool. The bytes are those of [`Stitcher::frame`].
///
/// # Errors
/// [`StitchError`] if a size does not fit.
pub fn stitch_bands<F: PixelFormat + Sync>(
    tables: &Tables<'_>,
    sampler: Sampler,
    left: &Frame<'_, F>,
    right: &Frame<'_, F>,
    out: &mut [u8],
) -> Result<(), StitchError> {
    let stitcher = Stitcher::<F>::new(tables, sampler)?;
    let row_bytes = stitcher.row_bytes();
    if out.len() != row_bytes * usize::from(stitcher.rows()) {
        return Err(StitchError::OutputLength {
            expected: row_bytes,
        });
    }
    out.par_chunks_mut(row_bytes * BAND_ROWS)
        .enumerate()
        .try_for_each(|(band, rows)| {
            for (i, row) in rows.chunks_mut(row_bytes).enumerate() {
                stitcher.row(left, right, (band * BAND_ROWS + i) as u16, row)?;
            }
            Ok(())
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BakeOptions, Format, Pair, Pass, bake, stitch, stitch_parallel};
    use tectum_core::Gray8;
    use tectum_optics::{Projection, Rig};

    /// A table whose height is no multiple of a band's.
    fn table() -> Vec<u8> {
        let eye = "size_px = [160, 160]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
                   focal_px_per_rad = 43.0, centre_px = [79.5, 79.5] }\n";
        let text = format!(
            "name = 'small'\nmedium = 'air'\nstitch_distance_m = inf\n[mount]\npsi_deg = 20.0\n\
             tau_deg = 10.0\n[left]\n{eye}[right]\n{eye}"
        );
        let rig = Rig::from_toml(&text, "small").unwrap();
        let options = BakeOptions {
            output: Projection::Equirect.output_map([240, 120]).unwrap(),
            max_error_px: 1.0,
            feather_rad: 0.2,
        };
        bake(&rig, &options).unwrap().bytes
    }

    #[test]
    fn bands_give_the_bytes_of_one_thread() {
        let bytes = table();
        let tables = Tables::parse(&bytes).unwrap();
        let [left, right]: [Vec<u8>; 2] =
            [31, 57].map(|k| (0..160 * 160 * 3).map(|i| (i * k % 251) as u8).collect());
        let pair = Pair {
            left: &left,
            right: &right,
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(3)
            .build()
            .unwrap();
        for format in Format::ALL {
            for sampler in [Sampler::Nearest, Sampler::Bilinear] {
                let serial = stitch(&tables, format, sampler, Pass::Both, pair).unwrap();
                let bands = pool
                    .install(|| stitch_parallel(&tables, format, sampler, pair))
                    .unwrap();
                assert!(serial == bands, "{format:?} {sampler:?}");
            }
        }
    }

    #[test]
    fn a_buffer_of_another_length_is_refused() {
        let bytes = table();
        let tables = Tables::parse(&bytes).unwrap();
        let frame = Frame::<Gray8>::new(&[0; 160 * 160], 160, 160, 160).unwrap();
        for rows in [119, 121] {
            let mut out = vec![0; 240 * rows];
            let error = stitch_bands(&tables, Sampler::Nearest, &frame, &frame, &mut out);
            assert_eq!(error, Err(StitchError::OutputLength { expected: 240 }));
        }
    }
}
