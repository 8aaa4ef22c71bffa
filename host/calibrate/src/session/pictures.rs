//! Which pictures a session has.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use image::ImageReader;

use super::SessionError;

/// Endings of picture files, lower case.
const ENDINGS: [&str; 9] = [
    "png", "jpg", "jpeg", "pgm", "ppm", "pnm", "bmp", "tif", "tiff",
];

/// Pictures by the files and folders given, in that order; those of a folder (not of folders
/// within) sorted by name, hidden files left out.
///
/// # Errors
/// [`SessionError`] if a file or folder is not there, or a folder holds no picture.
pub fn list(given: &[PathBuf]) -> Result<Vec<PathBuf>, SessionError> {
    let mut files = Vec::new();
    for path in given {
        let read = |source| SessionError::Read {
            path: path.clone(),
            source,
        };
        if fs::metadata(path).map_err(read)?.is_file() {
            files.push(path.clone());
            continue;
        }
        let mut inside = Vec::new();
        for entry in fs::read_dir(path).map_err(read)? {
            let file = entry.map_err(read)?.path();
            if is_picture(&file) {
                inside.push(file);
            }
        }
        if inside.is_empty() {
            return Err(SessionError::NoPictures {
                path: path.clone(),
                formats: format!(".{}", ENDINGS.join(", .")),
            });
        }
        inside.sort();
        files.extend(inside);
    }
    Ok(files)
}

fn is_picture(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let ending = file.extension().unwrap_or_default().to_string_lossy();
    !name.starts_with('.') && ENDINGS.contains(&&*ending.to_lowercase()) && file.is_file()
}

/// Refuses pictures of more than one size, by their headers alone: before any work is done. Files
/// that cannot be read have no size here; detection names them.
///
/// # Errors
/// [`SessionError::Sizes`] says which sizes, how many of each, and names them.
pub fn check_sizes(files: &[PathBuf]) -> Result<(), SessionError> {
    let mut by_size = BTreeMap::<(u32, u32), Vec<&Path>>::new();
    for file in files {
        let size = ImageReader::open(file)
            .and_then(ImageReader::with_guessed_format)
            .ok()
            .and_then(|reader| reader.into_dimensions().ok());
        if let Some(size) = size {
            by_size.entry(size).or_default().push(file);
        }
    }
    if by_size.len() < 2 {
        return Ok(());
    }
    let mut sizes: Vec<_> = by_size.into_iter().collect();
    sizes.sort_by_key(|(_, files)| std::cmp::Reverse(files.len()));
    let described: Vec<_> = sizes
        .iter()
        .map(|((width, height), files)| {
            format!("{} of {width}x{height} ({})", files.len(), names(files))
        })
        .collect();
    Err(SessionError::Sizes(described.join(", ")))
}

/// The first few names.
fn names(files: &[&Path]) -> String {
    const SHOWN: usize = 4;
    let mut text: Vec<_> = files
        .iter()
        .take(SHOWN)
        .map(|file| file.display().to_string())
        .collect();
    if files.len() > SHOWN {
        text.push("...".into());
    }
    text.join(", ")
}

#[cfg(test)]
mod tests {
    use image::GrayImage;

    use super::*;

    #[test]
    fn folders_give_their_pictures_by_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.PNG", "a.jpg", "notes.txt", ".hidden.png", "c.tiff"] {
            fs::write(folder.path().join(name), b"x").unwrap();
        }
        fs::create_dir(folder.path().join("d.png")).unwrap();
        let single = folder.path().join("notes.txt");
        let files = list(&[folder.path().into(), single]).unwrap();
        let names: Vec<_> = files
            .iter()
            .map(|file| file.file_name().unwrap().to_string_lossy())
            .collect();
        // A file that is named counts, whatever its ending.
        assert_eq!(names, ["a.jpg", "b.PNG", "c.tiff", "notes.txt"]);
        let empty = folder.path().join("d.png");
        let message = list(&[empty]).unwrap_err().to_string();
        assert!(
            message.contains("no picture") && message.contains(".pgm"),
            "{message}"
        );
        let message = list(&[folder.path().join("none")]).unwrap_err().to_string();
        assert!(message.contains("cannot be read"), "{message}");
    }

    #[test]
    fn sizes_are_counted_and_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, width, height| {
            let path = folder.path().join(name);
            GrayImage::new(width, height).save(&path).unwrap();
            path
        };
        let mut files: Vec<_> = (0..6).map(|i| file(&format!("{i}.png"), 8, 6)).collect();
        files.push(folder.path().join("unreadable.png"));
        assert!(check_sizes(&files).is_ok());
        files.push(file("odd.png", 6, 8));
        let message = check_sizes(&files).unwrap_err().to_string();
        assert!(
            message.contains("6 of 8x6 (") && message.contains("..."),
            "{message}"
        );
        assert!(
            message.contains("1 of 6x8 (") && message.contains("odd.png"),
            "{message}"
        );
    }
}
