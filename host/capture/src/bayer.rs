//! Colours of sensors that give one of them for each pixel.
//!
//! Missing colours are the mean of the nearest pixels that have them (bilinear interpolation, as in
//! Sakamoto et al., "Software pixel interpolation for digital still cameras suitable for a 32-bit
//! MCU", IEEE Transactions on Consumer Electronics 44, 1998): the four to the sides for green, the
//! two in the row or the column or the four across for red and blue. A mean of n values of sum s is
//! `floor((s + n / 2) / n)`. At the border the mosaic goes on as its mirror image about the outermost
//! row or column, which has the colours where they belong.

/// The colours of the upper left four pixels of a mosaic, row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mosaic {
    /// Red, green; green, blue.
    Rggb,
    /// Blue, green; green, red.
    Bggr,
    /// Green, red; blue, green.
    Grbg,
    /// Green, blue; red, green.
    Gbrg,
}

/// Bits of a sensor's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Depth {
    /// A byte for each pixel.
    Eight,
    /// A little-endian 16-bit word for each pixel, the value in its lower ten bits. Pictures have its
    /// upper eight.
    Ten,
}

/// Layout of a mosaic's bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bayer {
    /// Which colour is where.
    pub mosaic: Mosaic,
    /// Bits of a value.
    pub depth: Depth,
}

impl Bayer {
    /// All of them, eight bits first.
    pub const ALL: [Self; 8] = {
        use Depth::{Eight, Ten};
        use Mosaic::{Bggr, Gbrg, Grbg, Rggb};
        const fn of(mosaic: Mosaic, depth: Depth) -> Bayer {
            Bayer { mosaic, depth }
        }
        [
            of(Rggb, Eight),
            of(Bggr, Eight),
            of(Grbg, Eight),
            of(Gbrg, Eight),
            of(Rggb, Ten),
            of(Bggr, Ten),
            of(Grbg, Ten),
            of(Gbrg, Ten),
        ]
    };

    /// Four-character code of Video4Linux.
    pub fn fourcc(self) -> &'static str {
        match (self.mosaic, self.depth) {
            (Mosaic::Rggb, Depth::Eight) => "RGGB",
            (Mosaic::Bggr, Depth::Eight) => "BA81",
            (Mosaic::Grbg, Depth::Eight) => "GRBG",
            (Mosaic::Gbrg, Depth::Eight) => "GBRG",
            (Mosaic::Rggb, Depth::Ten) => "RG10",
            (Mosaic::Bggr, Depth::Ten) => "BG10",
            (Mosaic::Grbg, Depth::Ten) => "BA10",
            (Mosaic::Gbrg, Depth::Ten) => "GB10",
        }
    }

    /// Bytes to a pixel.
    pub fn bytes_per_pixel(self) -> usize {
        match self.depth {
            Depth::Eight => 1,
            Depth::Ten => 2,
        }
    }

    /// The picture as three bytes a pixel, rows tightly packed, from rows that start every
    /// `stride_bytes`. White balance, black level and gamma are left as the sensor gives them.
    ///
    /// # Panics
    /// If `data` has fewer bytes than that.
    pub(crate) fn to_rgb8(
        self,
        data: &[u8],
        [width, height]: [usize; 2],
        stride_bytes: usize,
    ) -> Vec<u8> {
        let values: Vec<u8> = (0..height)
            .flat_map(|y| {
                let row = &data[y * stride_bytes..][..width * self.bytes_per_pixel()];
                let words = row.chunks_exact(self.bytes_per_pixel());
                words.map(move |word| match *word {
                    [low, high] => ((u16::from_le_bytes([low, high]) & 1023) >> 2) as u8,
                    _ => word[0],
                })
            })
            .collect();
        // Where red is among the upper left four; blue is across from it.
        let [red_x, red_y] = match self.mosaic {
            Mosaic::Rggb => [0, 0],
            Mosaic::Grbg => [1, 0],
            Mosaic::Gbrg => [0, 1],
            Mosaic::Bggr => [1, 1],
        };
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let [above, below] = neighbours(y, height);
            for x in 0..width {
                let [left, right] = neighbours(x, width);
                let at = |x: usize, y: usize| u32::from(values[y * width + x]);
                let own = at(x, y);
                let beside = || mean([at(left, y), at(right, y)]);
                let over = || mean([at(x, above), at(x, below)]);
                let sides = || mean([at(left, y), at(right, y), at(x, above), at(x, below)]);
                let across = || {
                    let [a, b] = [above, below].map(|y| at(left, y));
                    mean([a, b, at(right, above), at(right, below)])
                };
                let colours = match (x % 2 == red_x, y % 2 == red_y) {
                    (true, true) => [own, sides(), across()],
                    (false, true) => [beside(), own, over()],
                    (true, false) => [over(), own, beside()],
                    (false, false) => [across(), sides(), own],
                };
                rgb.extend(colours.map(|value| value as u8));
            }
        }
        rgb
    }
}

/// Rounded half up.
fn mean<const N: usize>(values: [u32; N]) -> u32 {
    let count = N as u32;
    (values.iter().sum::<u32>() + count / 2) / count
}

/// The places before and after `at` of `count`, mirrored about the first and the last; a single one
/// is its own neighbour.
fn neighbours(at: usize, count: usize) -> [usize; 2] {
    let last = count - 1;
    let before = at.checked_sub(1).unwrap_or(1.min(last));
    let after = if at < last {
        at + 1
    } else {
        last.saturating_sub(1)
    };
    [before, after]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [7, 5];

    /// What a sensor gives of a picture, by its definition: the colour at each place, in rows with
    /// `padding` bytes of rubbish behind them.
    fn sensed(bayer: Bayer, padding: usize, rgb: impl Fn(usize, usize) -> [u16; 3]) -> Vec<u8> {
        let order = match bayer.mosaic {
            Mosaic::Rggb => [[0, 1], [1, 2]],
            Mosaic::Bggr => [[2, 1], [1, 0]],
            Mosaic::Grbg => [[1, 0], [2, 1]],
            Mosaic::Gbrg => [[1, 2], [0, 1]],
        };
        let mut bytes = Vec::new();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let value = rgb(x, y)[order[y % 2][x % 2]];
                match bayer.depth {
                    Depth::Eight => bytes.push(value as u8),
                    Depth::Ten => bytes.extend((value << 2 | 3).to_le_bytes()),
                }
            }
            bytes.extend(std::iter::repeat_n(0xa5, padding));
        }
        bytes
    }

    fn seen(bayer: Bayer, padding: usize, rgb: impl Fn(usize, usize) -> [u16; 3]) -> Vec<[u8; 3]> {
        let stride_bytes = SIZE[0] * bayer.bytes_per_pixel() + padding;
        let bytes = bayer.to_rgb8(&sensed(bayer, padding, rgb), SIZE, stride_bytes);
        bytes.as_chunks().0.to_vec()
    }

    #[test]
    fn a_plain_colour_is_that_colour_to_the_border() {
        for bayer in Bayer::ALL {
            for padding in [0, 6] {
                let seen = seen(bayer, padding, |_, _| [200, 30, 90]);
                assert_eq!(seen, [[200, 30, 90]; 35], "{bayer:?}");
            }
        }
    }

    #[test]
    fn a_slope_is_kept_away_from_the_border() {
        for bayer in Bayer::ALL {
            let slope = |x: usize, y: usize| {
                let [x, y] = [x, y].map(|v| v as u16);
                [10 + 4 * x + 6 * y, 250 - 8 * x - 2 * y, 20 + 10 * x]
            };
            let seen = seen(bayer, 0, slope);
            for y in 1..SIZE[1] - 1 {
                for x in 1..SIZE[0] - 1 {
                    let wanted = slope(x, y).map(|value| value as u8);
                    assert_eq!(seen[y * SIZE[0] + x], wanted, "{bayer:?} ({x}, {y})");
                }
            }
        }
    }

    #[test]
    fn means_are_rounded_half_up_and_borders_mirrored() {
        let bayer = Bayer {
            mosaic: Mosaic::Rggb,
            depth: Depth::Eight,
        };
        let rgb = bayer.to_rgb8(&[1, 2, 4, 8, 16, 33, 5, 9, 13], [3, 3], 3);
        // Upper left, red: green of 2, 2, 8, 8; blue of 16 alone.
        assert_eq!(rgb[..3], [1, 5, 16]);
        // Its right neighbour, green in red's row: red of 1 and 4, blue of 16 and its mirror.
        assert_eq!(rgb[3..6], [3, 2, 16]);
        // The middle, blue: red of 1, 4, 5, 13; green of 2, 8, 33, 9.
        assert_eq!(rgb[12..15], [6, 13, 16]);
        assert_eq!(bayer.to_rgb8(&[7], [1, 1], 1), [7, 7, 7]);
    }

    #[test]
    fn ten_bits_are_a_word_whose_upper_bits_do_not_count() {
        let bayer = Bayer {
            mosaic: Mosaic::Gbrg,
            depth: Depth::Ten,
        };
        let [low, high] = (0xfc00_u16 | 0x3ff).to_le_bytes();
        assert_eq!(bayer.to_rgb8(&[low, high], [1, 1], 2), [255; 3]);
    }
}
