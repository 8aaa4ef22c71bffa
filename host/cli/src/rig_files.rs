//! A rig file and the pictures beside it that its `[stitching]` names.

use std::path::{Path, PathBuf};

use tectum_optics::{NamedFile, RgbCurves, Rig, Stitching, StitchingFile};
use tectum_stitch::align::Warp;
use tectum_stitch::colour::tone_png;

use crate::files;

/// Names of the files.
pub struct RigFiles {
    rig: PathBuf,
    seam: PathBuf,
    tone: PathBuf,
    warp: PathBuf,
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
        let stem = rig.file_stem().unwrap_or_default().to_string_lossy();
        let beside = |what: &str| rig.with_file_name(format!("{stem}-{what}.png"));
        Self {
            rig: rig.to_owned(),
            seam: beside("seam"),
            tone: beside("tone"),
            warp: beside("warp"),
        }
    }

    /// Every file that may be written.
    pub fn all(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.seam, &self.tone, &self.warp, &self.rig].into_iter()
    }

    /// Writes the pictures, then the rig that names them, with a comment that says what it was made
    /// `from`; the rig as it is read back.
    pub fn write(&self, rig: &Rig, parts: &Parts, from: &str) -> anyhow::Result<Rig> {
        let mut named = StitchingFile::default();
        let write = |path: &Path, bytes: &[u8]| -> anyhow::Result<Option<NamedFile>> {
            files::write(path, bytes)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            Ok(Some(NamedFile::of(name.into_owned(), bytes)))
        };
        if let Some(png) = &parts.seam_png {
            named.seam = write(&self.seam, png)?;
        }
        if let Some(curves) = parts.curves {
            named.tone = write(&self.tone, &tone_png(curves)?)?;
        }
        if let Some(warp) = parts.warp {
            named.warp = write(&self.warp, &warp.png()?)?;
            named.warp_step_deg = Some(warp.step_deg());
        }
        let rig = rig.with_stitching(Stitching::default(), named);
        let text = format!(
            "# Made by tectum {} from {from}.\n{}",
            env!("CARGO_PKG_VERSION"),
            rig.to_toml()?
        );
        files::write(&self.rig, text.as_bytes())?;
        Ok(Rig::load(&self.rig)?)
    }

    /// The files that a rig of these parts consists of.
    pub fn written(&self, parts: &Parts) -> Vec<&Path> {
        let files = [
            (true, &self.rig),
            (parts.seam_png.is_some(), &self.seam),
            (parts.curves.is_some(), &self.tone),
            (parts.warp.is_some(), &self.warp),
        ];
        let written = files.into_iter().filter(|(written, _)| *written);
        written.map(|(_, path)| &**path).collect()
    }
}
