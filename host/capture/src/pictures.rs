//! Picture files as a source.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::ImageReader;

use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout, check_jpeg};

/// The picture files of a folder in the order of their names, or one picture: 8-bit RGB frames, the
/// n-th at time n. A file that cannot be decoded counts as corrupt.
#[derive(Debug)]
pub struct Pictures {
    name: String,
    files: std::vec::IntoIter<PathBuf>,
    format: FrameFormat,
    data: Vec<u8>,
    read: u32,
    health: Arc<Health>,
}

impl Pictures {
    /// Opens a picture file, or a folder of at least one.
    ///
    /// # Errors
    /// [`CaptureError::File`] if there is no picture; [`CaptureError::Io`] or
    /// [`CaptureError::NoDevice`] if the path cannot be read.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        let files = if path.is_dir() {
            let entries = std::fs::read_dir(path).map_err(|e| CaptureError::io(path, e))?;
            let mut files: Vec<PathBuf> = entries
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|file| is_picture(file) && !is_hidden(file))
                .collect();
            files.sort();
            files
        } else {
            vec![path.to_owned()]
        };
        let Some(first) = files.first() else {
            return Err(CaptureError::File {
                path: path.to_owned(),
                why: "no pictures in this folder: needed are PNG, JPEG, PNM, BMP or TIFF files"
                    .to_owned(),
            });
        };
        let first = decode(first)?;
        let side = |px: u32| u16::try_from(px).unwrap_or(u16::MAX);
        Ok(Self {
            name: path.display().to_string(),
            format: FrameFormat::packed(Layout::Rgb24, [side(first.width()), side(first.height())]),
            files: files.into_iter(),
            data: Vec::new(),
            read: 0,
            health: Arc::default(),
        })
    }
}

/// Such as `._1.png`, which macOS writes beside pictures on other file systems.
fn is_hidden(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default();
    name.as_encoded_bytes().starts_with(b".")
}

fn is_picture(file: &Path) -> bool {
    let ending = file.extension().unwrap_or_default().to_string_lossy();
    let known = [
        "png", "jpg", "jpeg", "ppm", "pgm", "pnm", "bmp", "tif", "tiff",
    ];
    known.contains(&&*ending.to_ascii_lowercase())
}

fn decode(path: &Path) -> Result<image::RgbImage, CaptureError> {
    let bytes = std::fs::read(path).map_err(|e| CaptureError::io(path, e))?;
    let reader = ImageReader::new(std::io::Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|e| CaptureError::io(path, e))?;
    if reader.format() == Some(image::ImageFormat::Jpeg) {
        // Decoders show what is missing as plain grey.
        check_jpeg(&bytes).map_err(|damage| CaptureError::File {
            path: path.to_owned(),
            why: format!("not a sound JPEG picture: {damage}"),
        })?;
    }
    match reader.decode() {
        Ok(picture) => Ok(picture.into_rgb8()),
        Err(error) => Err(CaptureError::File {
            path: path.to_owned(),
            why: format!("not a sound PNG, JPEG, PNM, BMP or TIFF: {error}"),
        }),
    }
}

impl FrameSource for Pictures {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let Some(file) = self.files.next() else {
            return Ok(Next::End);
        };
        self.read += 1;
        let Ok(picture) = decode(&file) else {
            self.health.corrupt();
            return Ok(Next::Nothing);
        };
        let size = [picture.width(), picture.height()];
        if size != self.format.size_px.map(u32::from) {
            return Err(CaptureError::File {
                path: file,
                why: format!(
                    "{}x{} px, the first picture of the folder is {}: give pictures of one size",
                    size[0], size[1], self.format
                ),
            });
        }
        self.data = picture.into_raw();
        self.health.frame(0);
        Ok(Next::Frame(Frame {
            data: &self.data,
            format: self.format,
            time_ns: i64::from(self.read - 1),
            sequence: self.read - 1,
            superseded: false,
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.health.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_its_pictures_by_name_and_counts_the_broken() {
        let folder = tempfile::tempdir().unwrap();
        for (name, value) in [("b.png", 2), ("a.png", 1), ("d.png", 4)] {
            image::RgbImage::from_pixel(4, 2, image::Rgb([value; 3]))
                .save(folder.path().join(name))
                .unwrap();
        }
        std::fs::write(folder.path().join("c.png"), b"no picture").unwrap();
        std::fs::write(folder.path().join("notes.txt"), b"no picture").unwrap();
        let mut source = Pictures::open(folder.path()).unwrap();
        let mut seen = Vec::new();
        loop {
            match source.next().unwrap() {
                Next::Frame(frame) => seen.push((frame.data[0], frame.sequence)),
                Next::Nothing => {}
                Next::End => break,
            }
        }
        assert_eq!(seen, [(1, 0), (2, 1), (4, 3)]);
        assert_eq!(source.health().counts().corrupt, 1);
    }

    #[test]
    fn nothing_to_read_is_one_clear_message() {
        let folder = tempfile::tempdir().unwrap();
        let error = Pictures::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("no pictures"), "{error}");
        let error = Pictures::open(&folder.path().join("x.png")).unwrap_err();
        assert!(matches!(error, CaptureError::NoDevice(_)), "{error}");
    }
}
