//! Borrowed camera frames.

use core::marker::PhantomData;

use crate::format::PixelFormat;

/// Why bytes are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// Fewer bytes than the size and stride need.
    TooShort {
        /// Bytes that the last pixel ends at.
        needed: usize,
    },
    /// The stride is shorter than a row of pixels.
    Stride {
        /// Bytes in a row of pixels.
        needed: usize,
    },
    /// A width or height of 0, or an odd width in a format whose pixels come in pairs.
    Size,
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooShort { needed } => write!(f, "the frame needs {needed} bytes"),
            Self::Stride { needed } => write!(f, "the stride must be at least {needed} bytes"),
            Self::Size => write!(
                f,
                "width and height must be positive (even width for 4:2:2 and 4:2:0)"
            ),
        }
    }
}

impl core::error::Error for FrameError {}

/// One picture of an eye in pixel format `F`, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a, F> {
    data: &'a [u8],
    width_px: u16,
    height_px: u16,
    stride_bytes: usize,
    format: PhantomData<F>,
}

impl<'a, F: PixelFormat> Frame<'a, F> {
    /// A frame of `width_px` x `height_px` pixels whose rows of bytes, one for each
    /// [`PixelFormat::ROWS`] of the picture, start every `stride_bytes`.
    /// Bytes after the last pixel are ignored.
    ///
    /// # Errors
    /// [`FrameError`] if the bytes cannot hold such a frame.
    pub fn new(
        data: &'a [u8],
        width_px: u16,
        height_px: u16,
        stride_bytes: usize,
    ) -> Result<Self, FrameError> {
        let row = usize::from(width_px) * F::BYTES_PER_PIXEL;
        if width_px == 0 || height_px == 0 || !usize::from(width_px).is_multiple_of(F::PIXELS) {
            return Err(FrameError::Size);
        }
        if stride_bytes < row {
            return Err(FrameError::Stride { needed: row });
        }
        let rows = usize::from(height_px).div_ceil(F::ROWS);
        let needed = (rows - 1)
            .checked_mul(stride_bytes)
            .and_then(|above| above.checked_add(row))
            .unwrap_or(usize::MAX);
        let data = data.get(..needed).ok_or(FrameError::TooShort { needed })?;
        Ok(Self {
            data,
            width_px,
            height_px,
            // Of a single row no stride matters; this one leads just out of it.
            stride_bytes: stride_bytes.min(needed),
            format: PhantomData,
        })
    }

    /// Width and height, px.
    pub fn size_px(&self) -> [u16; 2] {
        [self.width_px, self.height_px]
    }

    /// The bytes of the pixel at `[x, y]`, and what follows them. Of those that share bytes in a row
    /// each has its part of them.
    pub(crate) fn pixel(&self, [x, y]: [u16; 2]) -> Option<&'a [u8]> {
        let at = usize::from(y) / F::ROWS * self.stride_bytes + usize::from(x) * F::BYTES_PER_PIXEL;
        self.data.get(at..)
    }

    /// All bytes up to the last pixel's.
    pub(crate) fn data(&self) -> &'a [u8] {
        self.data
    }

    pub(crate) fn stride_bytes(&self) -> usize {
        self.stride_bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Chroma420, Gray8, Rgb8, Yuyv};

    #[test]
    fn the_last_row_needs_no_padding() {
        let bytes = [0; 8 * 2 + 6];
        assert!(Frame::<Rgb8>::new(&bytes, 2, 3, 8).is_ok());
        let error = Frame::<Rgb8>::new(&bytes[1..], 2, 3, 8).unwrap_err();
        assert_eq!(error, FrameError::TooShort { needed: 22 });
    }

    #[test]
    fn the_stride_of_a_single_row_leads_just_out_of_it() {
        for rows in [1, 2] {
            let frame = Frame::<Chroma420>::new(&[0; 4], 4, rows, usize::MAX).unwrap();
            assert_eq!((frame.stride_bytes(), frame.data().len()), (4, 4));
        }
    }

    #[test]
    fn pixels_of_a_cell_are_in_the_row_that_they_share() {
        let bytes: [u8; 4 * 6] = core::array::from_fn(|i| i as u8);
        let frame = Frame::<Chroma420>::new(&bytes, 4, 8, 6).unwrap();
        for (at, first) in [([0, 0], 0), ([2, 1], 2), ([0, 2], 6), ([2, 7], 20)] {
            assert_eq!(frame.pixel(at).unwrap()[0], first);
        }
        let frame = Frame::<Gray8>::new(&bytes, 4, 4, 6).unwrap();
        assert_eq!(frame.pixel([2, 3]).unwrap()[0], 20);
    }

    #[test]
    fn absurd_sizes_are_refused() {
        assert_eq!(
            Frame::<Gray8>::new(&[], 0, 1, 1).unwrap_err(),
            FrameError::Size
        );
        assert_eq!(
            Frame::<Yuyv>::new(&[0; 9], 3, 1, 9).unwrap_err(),
            FrameError::Size
        );
        let error = Frame::<Rgb8>::new(&[0; 9], 3, 1, 8).unwrap_err();
        assert_eq!(error, FrameError::Stride { needed: 9 });
        let error = Frame::<Gray8>::new(&[0; 9], 3, 3, usize::MAX).unwrap_err();
        assert_eq!(error, FrameError::TooShort { needed: usize::MAX });
    }
}
