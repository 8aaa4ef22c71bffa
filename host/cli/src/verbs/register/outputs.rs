//! The rig, the pictures that it names, and the report.

use std::path::{Path, PathBuf};

use tectum_optics::Rig;

use super::Args;
use super::appearance::Appearance;
use crate::rig_files::{Parts, RigFiles};

/// Files to write.
pub struct Outputs {
    files: RigFiles,
    report: Option<PathBuf>,
}

impl Outputs {
    pub fn new(args: &Args) -> Self {
        Self {
            files: RigFiles::new(&args.output),
            report: args.report.clone(),
        }
    }

    /// The files whose names were given.
    pub fn named(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(self.files.rig()).chain(self.report.as_deref())
    }

    /// Writes the pictures, then the rig that names them; the rig as it is read back, and the files
    /// that it consists of.
    pub fn write_rig(&self, rig: &Rig, found: &Appearance) -> anyhow::Result<(Rig, Vec<PathBuf>)> {
        let seam = found.seam.as_ref();
        let parts = Parts {
            seam_png: seam
                .map(|s| s.shares.to_png([found.width_px, found.width_px / 2]))
                .transpose()?,
            curves: found.curves.as_ref(),
            warp: found.warp.as_ref(),
        };
        let from = "pictures that both eyes took at once";
        self.files.write(rig, &parts, from)
    }

    /// The page, if there is one.
    pub fn report(&self) -> Option<&Path> {
        self.report.as_deref()
    }
}
