//! A rig file and the pictures beside it that its `[stitching]` names.

use std::path::{Path, PathBuf};

use tectum_optics::{NamedFile, RgbCurves, Rig, Stitching, StitchingFile};
use tectum_stitch::align::Warp;
use tectum_stitch::colour::tone_png;

use crate::files;

/// Digits of a picture's hash in its name.
const HASH_DIGITS: usize = 8;

/// A rig to be written. The pictures that it names have a part of their own hash in their names,
/// so that writing a rig anew never changes a picture that the rig of before names.
pub struct RigFiles {
    rig: PathBuf,
}

/// What `[stitching]` will hold.
#[derive(Default)]
pub struct Parts<'a> {
    /// The left eye's shares as a PNG file.
    pub seam_png: Option<Vec<u8>>,
    /// Curves of both eyes.
    pub curves: Option<&'a [RgbCurves; 2]>,
    /// Bend.
    pub warp: Option<&'a Warp>,
}

impl RigFiles {
    /// The files of a rig that is written to `rig`.
    pub fn new(rig: &Path) -> Self {
        Self {
            rig: rig.to_owned(),
        }
    }

    /// The rig's own file.
    pub fn rig(&self) -> &Path {
        &self.rig
    }

    /// Writes the pictures and the rig that names them, with a comment that says what it was made
    /// `from`: all of them or nothing. The rig as it is read back, and the files that it consists of.
    pub fn write(
        &self,
        rig: &Rig,
        parts: &Parts,
        from: &str,
    ) -> anyhow::Result<(Rig, Vec<PathBuf>)> {
        let mut named = StitchingFile::default();
        let mut pictures = Vec::new();
        let mut add = |what: &str, bytes: Vec<u8>| {
            let file = self.picture(what, &bytes);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let entry = NamedFile::of(name.into_owned(), &bytes);
            pictures.push((file, bytes));
            Some(entry)
        };
        if let Some(png) = &parts.seam_png {
            named.seam = add("seam", png.clone());
        }
        if let Some(curves) = parts.curves {
            named.tone = add("tone", tone_png(curves)?);
        }
        if let Some(warp) = parts.warp {
            named.warp = add("warp", warp.png()?);
            named.warp_step_deg = Some(warp.step_deg());
        }
        let rig = rig.with_stitching(Stitching::default(), named);
        let text = format!(
            "# Made by tectum {} from {}.\n{}",
            env!("CARGO_PKG_VERSION"),
            // A name with a line break must not end the comment.
            from.replace(char::is_control, " "),
            rig.to_toml()?
        );
        let mut group: Vec<(&Path, &[u8])> = pictures
            .iter()
            .map(|(file, bytes)| (&**file, &**bytes))
            .collect();
        group.push((&self.rig, text.as_bytes()));
        files::write_group(&group)?;
        let pictures = pictures.into_iter().map(|(file, _)| file);
        let written = std::iter::once(self.rig.clone()).chain(pictures).collect();
        Ok((Rig::load(&self.rig)?, written))
    }

    /// `rig.toml` to `rig-seam-0123abcd.png`.
    fn picture(&self, what: &str, bytes: &[u8]) -> PathBuf {
        let stem = self.rig.file_stem().unwrap_or_default().to_string_lossy();
        let hash = NamedFile::of(String::new(), bytes).sha256;
        let name = format!("{stem}-{what}-{}.png", &hash[..HASH_DIGITS]);
        self.rig.with_file_name(name)
    }
}
