//! Frames taken apart into planes of plain numbers.

use crate::Format;

/// A frame as planes: luma, or red, green and blue, or luma and two planes of chroma.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    /// Width and height of the frame, px.
    pub size_px: [usize; 2],
    /// One plane a channel.
    pub planes: Vec<Plane>,
}

/// The values of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Columns and rows of pixels that share a value.
    pub cell_px: [usize; 2],
    /// Values in a row.
    pub width: usize,
    /// Row by row.
    pub values: Vec<f64>,
}

impl Planes {
    /// Takes `bytes` apart, tightly packed rows of `size_px`.
    ///
    /// # Panics
    /// If there are fewer bytes than that, or YUYV, UYVY or NV12 has an odd width.
    pub fn decode(format: Format, size_px: [usize; 2], bytes: &[u8]) -> Self {
        let [width, height] = size_px;
        let bytes = format.swapped(&bytes[..format.picture_bytes(size_px)]);
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
        let plane = |cell_px: [usize; 2], values: Vec<f64>| Plane {
            cell_px,
            width: width / cell_px[0],
            values,
        };
        let (whole, pairs, cells) = ([1, 1], [2, 1], [2, 2]);
        let planes = match format {
            Format::Gray8 => vec![plane(whole, every(0, 1))],
            Format::Rgb8 => (0..3).map(|i| plane(whole, every(i, 3))).collect(),
            Format::Rgb565 | Format::Rgb565Be => {
                vec![
                    plane(whole, bits(11, 31)),
                    plane(whole, bits(5, 63)),
                    plane(whole, bits(0, 31)),
                ]
            }
            Format::Yuyv | Format::Uyvy => {
                assert!(width.is_multiple_of(2));
                vec![
                    plane(whole, every(0, 2)),
                    plane(pairs, every(1, 4)),
                    plane(pairs, every(3, 4)),
                ]
            }
            Format::Nv12 => {
                assert!(width.is_multiple_of(2));
                let luma = width * height;
                vec![
                    plane(whole, every(0, 1)[..luma].to_vec()),
                    plane(cells, every(luma, 2)),
                    plane(cells, every(luma + 1, 2)),
                ]
            }
        };
        Self { size_px, planes }
    }

    /// Puts the planes together again.
    pub fn encode(&self, format: Format) -> Vec<u8> {
        let [width, height] = self.size_px;
        let mut bytes = Vec::with_capacity(format.picture_bytes(self.size_px));
        let at = |plane: usize, i: usize| self.planes[plane].values[i];
        for i in 0..width * height {
            match format {
                Format::Gray8 | Format::Nv12 => bytes.push(at(0, i) as u8),
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
        if format == Format::Nv12 {
            let [u, v] = [1, 2].map(|plane| &self.planes[plane].values);
            bytes.extend(u.iter().zip(v).flat_map(|(u, v)| [*u as u8, *v as u8]));
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
            for size_px in [[4, 6], [4, 5]] {
                let planes = Planes::decode(format, size_px, &bytes);
                let length = format.picture_bytes(size_px);
                assert_eq!(planes.encode(format), bytes[..length], "{format:?}");
            }
        }
    }
}
