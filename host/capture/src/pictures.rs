//! Picture files as a source.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use crate::depth::{bits_used, to_8_bits};
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, JpegDamage, Layout, check_jpeg};

/// Pictures of 16 bits that are looked at beforehand, of each folder, evenly spread.
const MAX_LOOKED_AT: usize = 64;

/// The picture files of a folder in the order of their names, hidden ones left out, or one picture:
/// 8-bit RGB frames, the n-th at time n. A file that cannot be decoded counts as corrupt. Files of 16
/// bits have the bits that the largest value in the set needs, of both eyes where they are paired, so that all
/// are brightened alike; of a long set 64 pictures tell, and what is brighter is white.
#[derive(Debug)]
pub struct Pictures {
    name: String,
    files: std::vec::IntoIter<(i64, PathBuf)>,
    format: FrameFormat,
    bits: u32,
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
                .filter(|file| is_picture(file))
                .collect();
            files.sort();
            files
        } else {
            vec![path.to_owned()]
        };
        let bits = bits_of(&files);
        Self::of_files(path, (0..).zip(files).collect(), bits)
    }

    /// Pictures of two folders of which some belong together: `pairs` are indices into both lists,
    /// and have one time. Each of the others has a time of its own.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_paired(
        folders: [&Path; 2],
        files: [Vec<PathBuf>; 2],
        pairs: &[[usize; 2]],
    ) -> Result<[Self; 2], CaptureError> {
        let bits = files.iter().map(|files| bits_of(files)).max();
        let bits = bits.unwrap_or(8);
        let times = paired_times(files.each_ref().map(Vec::len), pairs);
        let [left, right] = files.map(Vec::into_iter);
        let timed = |files: std::vec::IntoIter<PathBuf>, times: &[i64]| {
            let mut timed: Vec<_> = times.iter().copied().zip(files).collect();
            timed.sort();
            timed
        };
        Ok([
            Self::of_files(folders[0], timed(left, &times[0]), bits)?,
            Self::of_files(folders[1], timed(right, &times[1]), bits)?,
        ])
    }

    /// Pictures with their times, in order.
    fn of_files(path: &Path, files: Vec<(i64, PathBuf)>, bits: u32) -> Result<Self, CaptureError> {
        let Some((_, first)) = files.first() else {
            return Err(CaptureError::File {
                path: path.to_owned(),
                why: "no pictures in this folder: needed are PNG, JPEG, PNM, BMP or TIFF files"
                    .to_owned(),
            });
        };
        let first = decode(first)?.picture;
        let side = |px: u32| u16::try_from(px).unwrap_or(u16::MAX);
        Ok(Self {
            name: path.display().to_string(),
            format: FrameFormat::packed(Layout::Rgb24, [side(first.width()), side(first.height())]),
            files: files.into_iter(),
            bits,
            data: Vec::new(),
            read: 0,
            health: Arc::default(),
        })
    }
}

/// The most bits that pictures of a set use; those that cannot be read are told when their turn comes.
fn bits_of(files: &[PathBuf]) -> u32 {
    let every = files.len().div_ceil(MAX_LOOKED_AT).max(1);
    let looked_at = files.iter().step_by(every).filter(|file| is_deep(file));
    let bits = looked_at.filter_map(|file| Some(decode(file).ok()?.bits));
    bits.max().unwrap_or(8)
}

/// Whether a file has 16 bits a sample, by its header.
fn is_deep(file: &Path) -> bool {
    let decoder = ImageReader::open(file).and_then(ImageReader::with_guessed_format);
    let decoder = decoder.ok().and_then(|reader| reader.into_decoder().ok());
    let deep = [
        ColorType::L16,
        ColorType::La16,
        ColorType::Rgb16,
        ColorType::Rgba16,
    ];
    decoder.is_some_and(|decoder| deep.contains(&decoder.color_type()))
}

/// A time for each picture: the left ones in order, their partners with them, what is alone on the
/// right behind all.
fn paired_times([left, right]: [usize; 2], pairs: &[[usize; 2]]) -> [Vec<i64>; 2] {
    let of_left: Vec<i64> = (0..left as i64).collect();
    let mut of_right: Vec<i64> = (0..right as i64).map(|i| left as i64 + i).collect();
    for [l, r] in pairs {
        if let (Some(time), Some(place)) = (of_left.get(*l), of_right.get_mut(*r)) {
            *place = *time;
        }
    }
    [of_left, of_right]
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
    !is_hidden(file) && known.contains(&&*ending.to_ascii_lowercase())
}

/// Why bytes are not a picture that can be used.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// A JPEG picture that is not whole.
    #[error("not a sound JPEG picture: {0}")]
    Jpeg(JpegDamage),
    /// Larger than the decoder allows.
    #[error("too large a picture: decoded it takes more than 512 MiB")]
    TooLarge,
    /// Anything else.
    #[error("not a sound PNG, JPEG, PNM, BMP or TIFF: {0}")]
    Unsound(ImageError),
}

/// Decodes a PNG, JPEG, PNM, BMP or TIFF file; its content tells which. A picture of 16 bits comes in
/// 8, of which its samples use what is there: those of 10, 12 or 14 bits are told by their largest value.
///
/// # Errors
/// [`PictureError`] for what must not be shown.
pub fn decode_picture(bytes: &[u8]) -> Result<DynamicImage, PictureError> {
    let deep = DeepPicture::decode(bytes)?;
    let bits = deep.bits;
    Ok(deep.in_8_bits(bits))
}

/// A picture as its file has it. Those of one shot are to be brightened alike: by the most bits of all.
#[derive(Debug)]
pub struct DeepPicture {
    picture: DynamicImage,
    bits: u32,
}

impl DeepPicture {
    /// Decodes as [`decode_picture`] does.
    ///
    /// # Errors
    /// [`PictureError`] for what must not be shown.
    pub fn decode(bytes: &[u8]) -> Result<Self, PictureError> {
        let (picture, is_scaled) = decode_bytes(bytes)?;
        let bits = match bits_used(&picture) {
            bits if bits > 8 && is_scaled => 16,
            bits => bits,
        };
        Ok(Self { picture, bits })
    }

    /// Bits that its samples use.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// Whether a file of 16 bits uses fewer.
    pub fn is_shallow(&self) -> bool {
        self.bits < 16
            && self.picture.color().bytes_per_pixel() / self.picture.color().channel_count() == 2
    }

    /// The picture in 8 bits, its samples taken as of `bits` where the file has 16.
    pub fn in_8_bits(self, bits: u32) -> DynamicImage {
        to_8_bits(self.picture, bits)
    }
}

/// The picture, and whether its samples already fill what they are stored in.
fn decode_bytes(bytes: &[u8]) -> Result<(DynamicImage, bool), PictureError> {
    let reader = ImageReader::new(std::io::Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| PictureError::Unsound(error.into()))?;
    if reader.format() == Some(ImageFormat::Jpeg) {
        // Decoders show what is missing as plain grey.
        check_jpeg(bytes).map_err(PictureError::Jpeg)?;
    }
    // PNM says its largest value, by which the decoder scales.
    let is_scaled = reader.format() == Some(ImageFormat::Pnm);
    let picture = reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => PictureError::TooLarge,
        error => PictureError::Unsound(error),
    })?;
    Ok((picture, is_scaled))
}

fn decode(path: &Path) -> Result<DeepPicture, CaptureError> {
    let bytes = std::fs::read(path).map_err(|e| CaptureError::io(path, e))?;
    DeepPicture::decode(&bytes).map_err(|error| CaptureError::File {
        path: path.to_owned(),
        why: error.to_string(),
    })
}

impl FrameSource for Pictures {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let Some((time_ns, file)) = self.files.next() else {
            return Ok(Next::End);
        };
        self.read += 1;
        let Ok(picture) = decode(&file) else {
            self.health.corrupt();
            return Ok(Next::Nothing);
        };
        let picture = picture.in_8_bits(self.bits).into_rgb8();
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
            time_ns,
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
    fn pictures_that_belong_together_have_one_time_and_hidden_ones_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = |eye: &str, name: &str| folder.path().join(eye).join(name);
        for (eye, names) in [("l", [1, 3, 4].as_slice()), ("r", &[1, 2, 3, 4])] {
            std::fs::create_dir(folder.path().join(eye)).unwrap();
            for name in names {
                image::RgbImage::from_pixel(2, 2, image::Rgb([*name; 3]))
                    .save(path(eye, &format!("{name}.png")))
                    .unwrap();
            }
            std::fs::write(path(eye, "._1.png"), b"beside pictures on sticks").unwrap();
        }
        let files = |eye: &str| -> Vec<PathBuf> {
            let files = std::fs::read_dir(folder.path().join(eye)).unwrap();
            let mut files: Vec<_> = files.map(|file| file.unwrap().path()).collect();
            files.retain(|file| is_picture(file));
            files.sort();
            files
        };
        let [left, right] = ["l", "r"].map(|eye| folder.path().join(eye));
        let [left, right] = Pictures::open_paired(
            [&left, &right],
            [files("l"), files("r")],
            &[[0, 0], [1, 2], [2, 3]],
        )
        .unwrap();
        let [left, right] = [left, right].map(|eye| Box::new(eye) as Box<dyn FrameSource>);
        let mut pairs = crate::Pairs::new(left, right, None, crate::Late::KeepAll).unwrap();
        let mut seen = Vec::new();
        pairs
            .for_each::<CaptureError>(&crate::Stop::default(), |pair, _| {
                seen.push([pair.left.data[0], pair.right.data[0]]);
                Ok(std::ops::ControlFlow::Continue(()))
            })
            .unwrap();
        assert_eq!(seen, [[1, 1], [3, 3], [4, 4]]);
        assert_eq!(pairs.statistics().alone, [0, 1]);
    }

    #[test]
    fn both_eyes_are_brightened_alike_through_the_whole_set() {
        let folder = tempfile::tempdir().unwrap();
        let names =
            ["l", "r"].map(|eye| [1, 2].map(|n| folder.path().join(format!("{eye}{n}.png"))));
        // 10 bits hold all but the last.
        for (file, value) in names.iter().flatten().zip([1000u16, 500, 1000, 4000]) {
            let deep: image::ImageBuffer<image::Luma<u16>, _> =
                image::ImageBuffer::from_pixel(2, 2, image::Luma([value]));
            deep.save(file).unwrap();
        }
        let files = names.map(|eye| eye.to_vec());
        let pairs = [[0, 0], [1, 1]];
        let eyes = Pictures::open_paired([folder.path(); 2], files, &pairs).unwrap();
        let seen = eyes.map(|mut eye| {
            [0, 1].map(|_| match eye.next().unwrap() {
                Next::Frame(frame) => frame.data[0],
                _ => panic!("no frame"),
            })
        });
        // Of 12 bits: 255 * 1000 / 4095 and so on.
        assert_eq!(seen, [[62, 31], [62, 249]]);
    }

    #[test]
    fn the_decoder_has_scaled_a_pnm_already() {
        let pgm = [&b"P5 1 1 1023\n"[..], &[0, 100]].concat();
        let gray = decode_picture(&pgm).unwrap().into_luma8();
        // 255 * 100 / 1023.
        assert_eq!(gray[(0, 0)].0, [25]);
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
