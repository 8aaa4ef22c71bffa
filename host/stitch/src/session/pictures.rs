//! Where the pictures come from.

use image::imageops::grayscale;
use image::{GrayImage, RgbImage};

use crate::Eyes;

/// Why a picture cannot be had.
pub type PictureError = Box<dyn std::error::Error + Send + Sync>;

/// Pictures that both eyes took at once, each read when it is looked at: all of them in gray, some in
/// colour.
pub trait Pictures: std::fmt::Debug + Sync {
    /// Number of pairs.
    fn count(&self) -> usize;

    /// What a person calls a pair.
    fn name(&self, pair: usize) -> String;

    /// Both pictures of a pair, gray.
    ///
    /// # Errors
    /// Why they cannot be read.
    fn gray(&self, pair: usize) -> Result<Eyes<GrayImage>, PictureError>;

    /// Both pictures of a pair in colour, of the sizes of the rig's eyes.
    ///
    /// # Errors
    /// Why they cannot be read, or do not fit the rig.
    fn rgb(&self, pair: usize) -> Result<Eyes<RgbImage>, PictureError>;
}

/// Pictures in memory, called by their numbers.
impl Pictures for Vec<Eyes<RgbImage>> {
    fn count(&self) -> usize {
        self.len()
    }

    fn name(&self, pair: usize) -> String {
        format!("pair {}", pair + 1)
    }

    fn gray(&self, pair: usize) -> Result<Eyes<GrayImage>, PictureError> {
        Ok(self[pair].each_ref().map(grayscale))
    }

    fn rgb(&self, pair: usize) -> Result<Eyes<RgbImage>, PictureError> {
        Ok(self[pair].clone())
    }
}
