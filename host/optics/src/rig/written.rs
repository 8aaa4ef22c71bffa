//! A rig's file and the pictures beside it that its `[stitching]` names.

use std::path::{Path, PathBuf};

use super::stitching::{self, NamedFile, StitchingFile};
use super::{Rig, RigError};

/// Digits of a picture's hash in its name.
const HASH_DIGITS: usize = 8;

/// What a rig's `[stitching]` will hold, as PNG files.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StitchingPictures {
    /// The left eye's shares, 8-bit gray.
    pub seam: Option<Vec<u8>>,
    /// Tone curves of both eyes, 256x2 px RGB.
    pub tone: Option<Vec<u8>>,
    /// Offsets of directions, 16-bit RGBA.
    pub warp: Option<Vec<u8>>,
    /// Angle of one step of the warp's values, degrees; needed with a warp.
    pub warp_step_deg: Option<f64>,
}

/// The files of a rig, complete but not written. The pictures have a part of their own hash in their
/// names, so that writing a rig anew never changes a picture that the rig of before names: a run that is
/// killed leaves the earlier rig usable, if the rig's own file is replaced last.
#[derive(Debug, Clone)]
pub struct RigFiles {
    rig: Rig,
    /// Pictures first, the rig last.
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl RigFiles {
    /// The files of `rig` with these pictures, to be written to `path`; a comment says what it was made
    /// `from`.
    ///
    /// # Errors
    /// [`RigError`] if a picture is not of the kind that `[stitching]` needs.
    pub fn new(
        rig: &Rig,
        pictures: StitchingPictures,
        path: &Path,
        from: &str,
    ) -> Result<Self, RigError> {
        let mut named = StitchingFile::default();
        let mut files = Vec::new();
        let mut add = |what: &str, bytes: Option<Vec<u8>>| {
            let bytes = bytes?;
            let file = picture_path(path, what, &bytes);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let entry = NamedFile::of(name.into_owned(), &bytes);
            files.push((file, bytes));
            Some(entry)
        };
        named.seam = add("seam", pictures.seam);
        named.tone = add("tone", pictures.tone);
        named.warp = add("warp", pictures.warp);
        named.warp_step_deg = named.warp.as_ref().and(pictures.warp_step_deg);
        let file = path.display().to_string();
        let bytes_of = |named: &NamedFile| {
            let mut files = files.iter();
            let found = files.find(|(path, _)| path.ends_with(&named.file));
            Ok(found.map_or_else(Vec::new, |(_, bytes)| bytes.clone()))
        };
        let stitching = stitching::read(&named, bytes_of, &file)?;
        let rig = rig.with_stitching(stitching, named);
        let text = rig.to_toml().map_err(|error| RigError::Syntax {
            file,
            message: error.to_string(),
        })?;
        let text = format!(
            "# Made by tectum {} from {}.\n{text}",
            env!("CARGO_PKG_VERSION"),
            // A name with a line break must not end the comment.
            from.replace(char::is_control, " "),
        );
        files.push((path.to_owned(), text.into_bytes()));
        Ok(Self { rig, files })
    }

    /// The rig, with the stitching that reading the files gives.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The files and what is in them, in the order in which they are to get their names: the rig is
    /// last.
    pub fn to_write(&self) -> impl Iterator<Item = (&Path, &[u8])> {
        self.files.iter().map(|(path, bytes)| (&**path, &**bytes))
    }

    /// The paths, the rig's first.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let rig = self.files.last().into_iter();
        let pictures = self.files.len().saturating_sub(1);
        rig.chain(&self.files[..pictures]).map(|(path, _)| &**path)
    }
}

/// `rig.toml` to `rig-seam-0123abcd.png`.
fn picture_path(rig: &Path, what: &str, bytes: &[u8]) -> PathBuf {
    let stem = rig.file_stem().unwrap_or_default().to_string_lossy();
    let hash = NamedFile::of(String::new(), bytes).sha256;
    let name = format!("{stem}-{what}-{}.png", &hash[..HASH_DIGITS]);
    rig.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
        [mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n\
        [left]\nsize_px = [480, 480]\nfield_deg = 160.0\n\
        lens = { model = \"equidistant\", focal_px_per_rad = 129.9, centre_px = [239.5, 239.5] }\n";

    fn seam() -> Vec<u8> {
        let shares = image::GrayImage::from_fn(16, 8, |x, _| image::Luma([16 * x as u8]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        let written = shares.write_to(&mut bytes, image::ImageFormat::Png);
        written.unwrap();
        bytes.into_inner()
    }

    #[test]
    fn the_rig_told_is_the_one_read_back() {
        let folder = tempfile::tempdir().unwrap();
        // An accent of two characters, and a comment that would end early.
        let path = folder.path().join("e\u{301}.toml");
        let pictures = StitchingPictures {
            seam: Some(seam()),
            ..StitchingPictures::default()
        };
        let rig = Rig::from_toml(RIG, "rig.toml").unwrap();
        let files = RigFiles::new(&rig, pictures, &path, "a\nname").unwrap();
        for (path, bytes) in files.to_write() {
            std::fs::write(path, bytes).unwrap();
        }
        assert_eq!(&Rig::load(&path).unwrap(), files.rig());
        let paths: Vec<&Path> = files.paths().collect();
        assert_eq!(paths[0], path);
        let name = paths[1].file_name().unwrap().to_string_lossy();
        assert!(
            name.starts_with("e\u{301}-seam-") && name.len() == "e\u{301}-seam-01234567.png".len()
        );
        assert_eq!(files.to_write().last().unwrap().0, path);
    }

    #[test]
    fn a_picture_of_another_kind_is_refused() {
        let rig = Rig::from_toml(RIG, "rig.toml").unwrap();
        let pictures = StitchingPictures {
            tone: Some(seam()),
            ..StitchingPictures::default()
        };
        let refused = RigFiles::new(&rig, pictures, Path::new("fish.toml"), "nothing");
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("8-bit RGB"), "{message}");
    }
}
