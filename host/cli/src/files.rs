//! Files in and out.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};
use tectum_tables::Tables;
use tempfile::NamedTempFile;

/// Reads a whole file; an empty one is an error.
pub fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let bytes = fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    if bytes.is_empty() {
        bail!("{}: the file is empty", path.display());
    }
    Ok(bytes)
}

/// Parses and proves a table that was read from `path`.
pub fn table<'a>(bytes: &'a [u8], path: &Path) -> anyhow::Result<Tables<'a>> {
    Tables::parse(bytes).map_err(|error| {
        anyhow::anyhow!(
            "{}: {error}. Needed is a table as `tectum bake` writes it: copy or bake it again",
            path.display()
        )
    })
}

/// Writes a file at once: under another name in the same folder, renamed when complete. Makes
/// the folder.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_whole(path, bytes).with_context(|| format!("{}: cannot be written", path.display()))
}

/// Refuses early what [`write()`] would refuse after long work. Makes the folder.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let place = new_file(path).with_context(|| format!("{}: cannot be written", path.display()));
    place.map(drop)
}

fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut file = new_file(path)?;
    file.write_all(bytes)?;
    file.persist(path)?;
    Ok(())
}

/// A file under another name in the folder of `path`; it goes away when dropped.
fn new_file(path: &Path) -> anyhow::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder)?;
    if path.is_dir() {
        bail!("it is a folder");
    }
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: readable by others, less what the umask takes.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    Ok(builder.prefix(".tectum-").tempfile_in(folder)?)
}
