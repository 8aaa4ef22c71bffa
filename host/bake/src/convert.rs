//! Pictures of 8-bit red, green, blue to the core's pixel formats and back.
//!
//! Luma and chroma are BT.601, full range, as in JPEG (ITU-T T.871).

use crate::Format;

/// `rgb` (three bytes a pixel, rows of `width_px` tightly packed) in another format. For YUYV and UYVY
/// the chroma of a pair is its even pixel's, where the formats site it, and for NV12 that of a cell its
/// upper left pixel's; an odd last pixel is dropped.
pub fn from_rgb8(format: Format, width_px: usize, rgb: &[u8]) -> Vec<u8> {
    let pixels = rgb.as_chunks::<3>().0;
    match format {
        Format::Rgb565Be | Format::Uyvy => format
            .swapped(&from_rgb8(format.unswapped(), width_px, rgb))
            .into_owned(),
        Format::Rgb8 => rgb.to_vec(),
        Format::Gray8 => pixels.iter().map(|p| luma(*p)).collect(),
        Format::Rgb565 => pixels
            .iter()
            .flat_map(|&[r, g, b]| {
                let [r, g, b] = [scale(r, 31), scale(g, 63), scale(b, 31)];
                (r << 11 | g << 5 | b).to_le_bytes()
            })
            .collect(),
        Format::Yuyv => pixels
            .as_chunks::<2>()
            .0
            .iter()
            .flat_map(|&[even, odd]| {
                let [u, v] = chroma(even);
                [luma(even), u, luma(odd), v]
            })
            .collect(),
        Format::Nv12 => {
            let upper = pixels.chunks_exact(width_px.max(1)).step_by(2);
            let upper_left = upper.flat_map(|row| row.as_chunks::<2>().0);
            let chroma = upper_left.flat_map(|&[pixel, _]| chroma(pixel));
            pixels.iter().map(|p| luma(*p)).chain(chroma).collect()
        }
    }
}

/// `bytes` in `format`, rows of `width_px` tightly packed, as three bytes a pixel.
pub fn to_rgb8(format: Format, width_px: usize, bytes: &[u8]) -> Vec<u8> {
    match format {
        Format::Rgb565Be | Format::Uyvy => {
            to_rgb8(format.unswapped(), width_px, &format.swapped(bytes))
        }
        Format::Rgb8 => bytes.to_vec(),
        Format::Gray8 => bytes.iter().flat_map(|y| [*y; 3]).collect(),
        Format::Rgb565 => bytes
            .as_chunks::<2>()
            .0
            .iter()
            .flat_map(|word| {
                let word = u16::from_le_bytes(*word);
                [
                    unscale(word >> 11, 31),
                    unscale(word >> 5 & 63, 63),
                    unscale(word & 31, 31),
                ]
            })
            .collect(),
        Format::Yuyv => bytes
            .as_chunks::<4>()
            .0
            .iter()
            .flat_map(|&[y0, u, y1, v]| [y0, y1].map(|y| colour(y, u, v)).concat())
            .collect(),
        Format::Nv12 => {
            // 1.5 bytes a pixel; of an odd height, the last row takes 2.
            let width = width_px.max(1);
            let (luma, chroma) = bytes.split_at(2 * bytes.len() / (3 * width) * width);
            let rows = luma.chunks_exact(width).enumerate();
            rows.flat_map(|(y, row)| {
                let cells = chroma.chunks_exact(width).nth(y / 2).unwrap_or_default();
                let pairs = row.as_chunks::<2>().0.iter().zip(cells.as_chunks::<2>().0);
                pairs.flat_map(|(pair, &[u, v])| pair.map(|y| colour(y, u, v)).concat())
            })
            .collect()
        }
    }
}

/// `value` of 255 as part of `max`, rounded.
fn scale(value: u8, max: u32) -> u16 {
    ((u32::from(value) * max * 2 + 255) / 510) as u16
}

fn unscale(value: u16, max: u32) -> u8 {
    ((u32::from(value) * 510 + max) / (2 * max)) as u8
}

fn luma([r, g, b]: [u8; 3]) -> u8 {
    let [r, g, b] = [r, g, b].map(u32::from);
    ((299 * r + 587 * g + 114 * b + 500) / 1000) as u8
}

fn chroma(rgb: [u8; 3]) -> [u8; 2] {
    let [r, _, b] = rgb.map(i32::from);
    let y = i32::from(luma(rgb));
    // T.871: Cb = (B - Y) / 1.772 + 128, Cr = (R - Y) / 1.402 + 128.
    [(b - y) * 1000 / 1772 + 128, (r - y) * 1000 / 1402 + 128].map(|c| c.clamp(0, 255) as u8)
}

fn colour(y: u8, u: u8, v: u8) -> [u8; 3] {
    let [y, u, v] = [i32::from(y), i32::from(u) - 128, i32::from(v) - 128];
    [
        y + v * 1402 / 1000,
        y - (u * 344 + v * 714) / 1000,
        y + u * 1772 / 1000,
    ]
    .map(|c| c.clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_within_their_depth() {
        for [r, g, b] in [[0, 0, 0], [255, 255, 255], [200, 30, 90], [10, 250, 128]] {
            let rgb = [r, g, b, r, g, b];
            for (format, tolerance) in [
                (Format::Rgb8, 0),
                // Half a step of 5 bits is 255 / 62.
                (Format::Rgb565, 5),
                (Format::Rgb565Be, 5),
                // Rounding of luma and both chromas, times up to 1.772.
                (Format::Yuyv, 3),
                (Format::Uyvy, 3),
                (Format::Nv12, 3),
            ] {
                let back = to_rgb8(format, 2, &from_rgb8(format, 2, &rgb));
                for (a, b) in back.iter().zip(rgb) {
                    assert!(a.abs_diff(b) <= tolerance, "{format:?} {rgb:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn bytes_are_in_the_order_that_formats_name() {
        let rgb = [255, 0, 0, 0, 0, 255];
        let [y0, u, y1, v] = [76, 86, 29, 255];
        assert_eq!(from_rgb8(Format::Yuyv, 2, &rgb), [y0, u, y1, v]);
        assert_eq!(from_rgb8(Format::Uyvy, 2, &rgb), [u, y0, v, y1]);
        assert_eq!(from_rgb8(Format::Rgb565, 2, &rgb), [0, 0xf8, 0x1f, 0]);
        assert_eq!(from_rgb8(Format::Rgb565Be, 2, &rgb), [0xf8, 0, 0, 0x1f]);
        // Three rows: the chroma of the second one is nobody's.
        let three = [rgb, [9; 6], rgb].concat();
        let nv12 = from_rgb8(Format::Nv12, 2, &three);
        assert_eq!(nv12, [y0, y1, 9, 9, y0, y1, u, v, u, v]);
        let back = to_rgb8(Format::Nv12, 2, &nv12);
        let cells = [[y0, y1], [9, 9], [y0, y1]].concat();
        let wanted: Vec<u8> = cells.iter().flat_map(|y| colour(*y, u, v)).collect();
        assert_eq!(back, wanted);
    }

    #[test]
    fn grey_stays_grey() {
        for v in 0..=255 {
            assert_eq!(from_rgb8(Format::Gray8, 1, &[v; 3]), [v]);
            assert_eq!(
                to_rgb8(Format::Yuyv, 2, &from_rgb8(Format::Yuyv, 2, &[v; 6])),
                [v; 6]
            );
        }
    }
}
