//! The rig and the pictures that it names.

use std::path::{Path, PathBuf};

use tectum_optics::{NamedFile, Rig, Stitching, StitchingFile};
use tectum_stitch::colour::tone_png;

use super::Args;
use super::appearance::Appearance;
use crate::files;

/// Files to write.
pub struct Outputs {
    rig: PathBuf,
    seam: PathBuf,
    tone: PathBuf,
    warp: PathBuf,
    report: Option<PathBuf>,
    seam_px: [u16; 2],
}

impl Outputs {
    pub fn new(args: &Args) -> Self {
        let stem = args
            .output
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let beside = |what: &str| args.output.with_file_name(format!("{stem}-{what}.png"));
        Self {
            rig: args.output.clone(),
            seam: beside("seam"),
            tone: beside("tone"),
            warp: beside("warp"),
            report: args.report.clone(),
            seam_px: [args.width, args.width / 2],
        }
    }

    /// Every file that may be written.
    pub fn all(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.seam, &self.tone, &self.warp, &self.rig]
            .into_iter()
            .chain(&self.report)
    }

    /// Writes the pictures, then the rig that names them; the rig as it is read back.
    pub fn write_rig(&self, rig: &Rig, found: &Appearance) -> anyhow::Result<Rig> {
        let mut named = StitchingFile::default();
        let write = |path: &Path, bytes: &[u8]| -> anyhow::Result<Option<NamedFile>> {
            files::write(path, bytes)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            Ok(Some(NamedFile::of(name.into_owned(), bytes)))
        };
        if let Some(seam) = &found.seam {
            named.seam = write(&self.seam, &seam.shares.to_png(self.seam_px)?)?;
        }
        if let Some(curves) = &found.curves {
            named.tone = write(&self.tone, &tone_png(curves)?)?;
        }
        if let Some(warp) = &found.warp {
            named.warp = write(&self.warp, &warp.png()?)?;
            named.warp_step_deg = Some(warp.step_deg());
        }
        let rig = rig.with_stitching(Stitching::default(), named);
        let text = format!(
            "# Made by tectum {} from pictures that both eyes took at once.\n{}",
            env!("CARGO_PKG_VERSION"),
            rig.to_toml()?
        );
        files::write(&self.rig, text.as_bytes())?;
        Ok(Rig::load(&self.rig)?)
    }

    /// The files that the rig as written consists of.
    pub fn written(&self, found: &Appearance) -> Vec<&Path> {
        let parts = [
            (true, &self.rig),
            (found.seam.is_some(), &self.seam),
            (found.curves.is_some(), &self.tone),
            (found.warp.is_some(), &self.warp),
        ];
        let written = parts.into_iter().filter(|(written, _)| *written);
        let written = written.map(|(_, path)| path);
        written.chain(&self.report).map(|path| &**path).collect()
    }
}
