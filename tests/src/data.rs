//! Real rigs, which are part of the repository, and real pictures, which are not.

use std::path::{Path, PathBuf};

use image::GrayImage;
use rayon::prelude::*;
use tectum_optics::Rig;
use tectum_test_data::repository;

/// Folder of the shipped tables.
pub fn baked_folder() -> PathBuf {
    repository().join("tables/baked")
}

/// All rig files of the repository, in the order of their names.
///
/// # Panics
/// If the folder cannot be read.
pub fn rig_files() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(repository().join("tables/rigs")).expect("tables/rigs");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files
}

/// A rig of the repository by name.
///
/// # Panics
/// If it cannot be read.
pub fn rig(name: &str) -> Rig {
    let path = repository()
        .join("tables/rigs")
        .join(name)
        .with_extension("toml");
    Rig::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// A picture file as 8-bit RGB and its width and height.
///
/// # Panics
/// If it cannot be read.
pub fn picture(path: &Path) -> (Vec<u8>, [u16; 2]) {
    let picture = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let size = [picture.width() as u16, picture.height() as u16];
    (picture.into_rgb8().into_raw(), size)
}

/// All pictures of a folder as 8-bit luma, in the order of their names.
///
/// # Panics
/// If the folder or a picture cannot be read.
pub fn pictures(folder: &Path) -> Vec<GrayImage> {
    let entries = std::fs::read_dir(folder).expect("the folder is listed");
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    files.retain(|file| image::ImageFormat::from_path(file).is_ok());
    files
        .par_iter()
        .map(|file| image::open(file).expect("a picture").to_luma8())
        .collect()
}

/// A picture file as 8-bit luma and its width and height.
///
/// # Panics
/// If it cannot be read.
pub fn luma(path: &Path) -> (Vec<u8>, [usize; 2]) {
    let (rgb, size) = picture(path);
    (
        tectum_bake::convert::from_rgb8(tectum_bake::Format::Gray8, size[0] as usize, &rgb),
        size.map(usize::from),
    )
}
