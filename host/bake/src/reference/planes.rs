//! Frames taken apart into planes of plain numbers.

use crate::Format;

/// A frame as planes: luma, or red, green and blue, or luma and two chroma planes of half width.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    /// Width and height of the frame, px.
    pub size_px: [usize; 2],
    /// One plane a channel: its width, and its values row by row.
    pub planes: Vec<(usize, Vec<f64>)>,
}

impl Planes {
    /// Takes `bytes` apart, tightly packed rows of `size_px`.
    ///
    /// # Panics
    /// If there are fewer bytes than that, or YUYV or UYVY has an odd width.
    pub fn decode(format: Format, size_px: [usize; 2], bytes: &[u8]) -> Self {
        let [width, height] = size_px;
        let bytes = format.swapped(&bytes[..width * height * format.bytes_per_pixel()]);
        let every = |start: usize, step: usize| {
            bytes[start..]
                .iter()
                .step_by(step)
                .map(|b| f64::from(*b))
                .collect::<Vec<_>>()
        };
        let words = || {
            bytes
                .as_chunks::<2>()
                .0
                .iter()
                .map(|b| u16::from_le_bytes(*b))
        };
        let bits = |shift: u16, mask: u16| words().map(|w| f64::from(w >> shift & mask)).collect();
        let planes = match format {
            Format::Gray8 => vec![(width, every(0, 1))],
            Format::Rgb8 => (0..3).map(|channel| (width, every(channel, 3))).collect(),
            Format::Rgb565 | Format::Rgb565Be => {
                vec![
                    (width, bits(11, 31)),
                    (width, bits(5, 63)),
                    (width, bits(0, 31)),
                ]
            }
            Format::Yuyv | Format::Uyvy => {
                assert!(width.is_multiple_of(2));
                vec![
                    (width, every(0, 2)),
                    (width / 2, every(1, 4)),
                    (width / 2, every(3, 4)),
                ]
            }
        };
        Self { size_px, planes }
    }

    /// Puts the planes together again.
    pub fn encode(&self, format: Format) -> Vec<u8> {
        let [width, height] = self.size_px;
        let mut bytes = Vec::with_capacity(width * height * format.bytes_per_pixel());
        let at = |plane: usize, i: usize| self.planes[plane].1[i];
        for i in 0..width * height {
            match format {
                Format::Gray8 => bytes.push(at(0, i) as u8),
                Format::Rgb8 => bytes.extend([0, 1, 2].map(|plane| at(plane, i) as u8)),
                Format::Rgb565 | Format::Rgb565Be => {
                    let [r, g, b] = [0, 1, 2].map(|plane| at(plane, i) as u16);
                    bytes.extend((r << 11 | g << 5 | b).to_le_bytes());
                }
                // Even width: even i is an even pixel, and i / 2 its chroma pair.
                Format::Yuyv | Format::Uyvy => {
                    bytes.extend([at(0, i) as u8, at(1 + i % 2, i / 2) as u8]);
                }
            }
        }
        format.swapped(&bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decode_and_encode_are_inverse() {
        let bytes: Vec<u8> = (0..96).map(|i| (i * 37 % 256) as u8).collect();
        for format in Format::ALL {
            let length = 24 * format.bytes_per_pixel();
            let planes = Planes::decode(format, [4, 6], &bytes);
            assert_eq!(planes.encode(format), bytes[..length], "{format:?}");
        }
    }
}
