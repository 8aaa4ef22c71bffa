//! Pictures that both eyes took at once.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use image::{GrayImage, RgbImage};
use tectum_calibrate::session::{list, pair_by_name};
use tectum_optics::Rig;
use tectum_stitch::Eyes;
use tectum_stitch::session::{PictureError, Pictures};

use crate::pictures;

/// Pictures of both eyes, given on the command line.
#[derive(clap::Args)]
pub struct PairArgs {
    /// Pictures of the left eye, or folders of them: pairs have the same name, or the same last
    /// number in it; one picture of each eye is a pair whatever its name
    #[arg(long, value_name = "A", num_args = 1.., required_unless_present = "picture", requires = "right")]
    left: Vec<PathBuf>,
    /// Pictures of the right eye, or folders of them
    #[arg(long, value_name = "B", num_args = 1.., requires = "left")]
    right: Vec<PathBuf>,
    /// Pictures that hold both eyes
    #[arg(long, value_name = "A", num_args = 1.., conflicts_with_all = ["left", "right"])]
    picture: Vec<PathBuf>,
}

/// Files of both eyes by shot, and those without a partner.
pub struct Paired {
    /// `[left, right]` of each shot.
    pub files: Vec<[PathBuf; 2]>,
    /// No partner for these.
    pub alone: Vec<PathBuf>,
}

impl PairArgs {
    /// Which files belong together.
    pub fn paired(&self) -> anyhow::Result<Paired> {
        if !self.picture.is_empty() {
            let files = list(&self.picture)?;
            return Ok(Paired {
                files: files.into_iter().map(|file| [file.clone(), file]).collect(),
                alone: Vec::new(),
            });
        }
        of_files(&self.left, &self.right)
    }
}

/// Pairs of pictures of both eyes, or of folders of them.
pub fn of_files(left: &[PathBuf], right: &[PathBuf]) -> anyhow::Result<Paired> {
    let [left, right] = [list(left)?, list(right)?];
    if let ([left], [right]) = (&left[..], &right[..]) {
        return Ok(Paired {
            files: vec![[left.clone(), right.clone()]],
            alone: Vec::new(),
        });
    }
    let pairs = pair_by_name(&left, &right)?;
    let files = pairs.pairs.iter();
    Ok(Paired {
        files: files
            .map(|[l, r]| [left[*l].clone(), right[*r].clone()])
            .collect(),
        alone: pairs.alone,
    })
}

/// Files that a rig's eyes took at once, as registration reads them.
#[derive(Debug)]
pub struct PairFiles<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// `[left, right]` of each shot.
    pub files: &'a [Eyes<PathBuf>],
}

impl Pictures for PairFiles<'_> {
    fn count(&self) -> usize {
        self.files.len()
    }

    fn name(&self, pair: usize) -> String {
        let [left, right] = self.files[pair].each_ref().map(|file| {
            let name = file.file_name().unwrap_or_default();
            name.to_string_lossy()
        });
        match left == right {
            true => left.into_owned(),
            false => format!("{left} and {right}"),
        }
    }

    fn gray(&self, pair: usize) -> Result<Eyes<GrayImage>, PictureError> {
        let [left, right] = &self.files[pair];
        Ok([pictures::load_gray(left)?, pictures::load_gray(right)?])
    }

    fn rgb(&self, pair: usize) -> Result<Eyes<RgbImage>, PictureError> {
        Ok(load(self.rig, &self.files[pair])?)
    }
}

/// Both pictures of a shot, of the sizes that the rig's eyes have.
pub fn load(rig: &Rig, files: &[PathBuf; 2]) -> anyhow::Result<[RgbImage; 2]> {
    let [left, right] = pictures::load_both(files.each_ref().map(|file| Some(&**file)))?;
    let one = |eye: usize, name: &str, picture: Option<RgbImage>| {
        let Some(rig_eye) = [&rig.left, &rig.right][eye] else {
            bail!("the rig has no {name} eye: two are needed");
        };
        let path: &Path = &files[eye];
        let picture = picture.with_context(|| path.display().to_string())?;
        let what_for = format!("the rig's {name} eye");
        pictures::check_size(&picture, path, rig_eye.eye.size_px, &what_for)?;
        Ok(picture)
    };
    Ok([one(0, "left", left)?, one(1, "right", right)?])
}
