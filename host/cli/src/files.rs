//! Files in and out. Every verb writes its outputs through this module.
//!
//! A regular file is written under a temporary name in its own folder, synced, and renamed when
//! complete; a symbolic link is followed first. A device, a FIFO or a socket is written through.
//! Several files can be replaced as one ([`write_group`]).

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use tectum_optics::{CalibratedEye, Rig, RigFiles, read_limited};
use tectum_tables::Tables;
use tempfile::NamedTempFile;

/// Largest file that is read whole, far above any picture or table.
const MAX_INPUT_BYTES: u64 = 2 << 30;
/// Prefix of temporary names.
const TEMPORARY: &str = ".tectum-";

/// Reads a whole file; an empty one is an error, as is one without an end.
pub fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let bytes = read_limited(path, MAX_INPUT_BYTES)
        .with_context(|| format!("{}: cannot be read", path.display()))?;
    if bytes.is_empty() {
        bail!("{}: the file is empty", path.display());
    }
    Ok(bytes)
}

/// Loads a rig, and tells a person what another tool's file leaves open.
pub fn rig(path: &Path) -> anyhow::Result<Rig> {
    let rig = Rig::load(path)?;
    notes(rig.remarks());
    Ok(rig)
}

/// Loads an eye, and tells a person what another tool's file leaves open.
pub fn eye(path: &Path) -> anyhow::Result<CalibratedEye> {
    let eye = CalibratedEye::load(path)?;
    notes(&eye.remarks);
    Ok(eye)
}

fn notes(remarks: &[String]) {
    for sentence in remarks {
        note(sentence);
    }
}

/// Tells a person something beside the results.
pub fn note(sentence: &str) {
    // Stderr that is closed harms nothing.
    let _ = writeln!(io::stderr(), "note: {sentence}");
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

/// Writes a file at once. Makes the folder.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_group(&[(path, bytes)])
}

/// Writes several files that belong together: all of them are complete on the disk under temporary
/// names before the first is renamed, so that a full disk leaves every file as it was. They are
/// renamed in order: give the one that names the others last.
pub fn write_group(files: &[(&Path, &[u8])]) -> anyhow::Result<()> {
    let cannot = |path: &Path| format!("{}: cannot be written", path.display());
    let mut complete = Vec::new();
    for (path, bytes) in files {
        complete.push(Pending::new(path, bytes).with_context(|| cannot(path))?);
    }
    for (pending, (path, _)) in complete.into_iter().zip(files) {
        pending.finish().with_context(|| cannot(path))?;
    }
    Ok(())
}

/// Writes a rig and the pictures that it names: all of them or nothing.
pub fn write_rig(rig: &RigFiles) -> anyhow::Result<()> {
    let group: Vec<(&Path, &[u8])> = rig.to_write().collect();
    write_group(&group)
}

/// Refuses early, before long work: outputs that cannot be written, the same output twice, and an
/// output that is one of the `inputs`.
pub fn check_outputs(
    outputs: impl IntoIterator<Item = impl AsRef<Path>>,
    inputs: impl IntoIterator<Item = impl AsRef<Path>>,
) -> anyhow::Result<()> {
    let mut seen = HashSet::new();
    let inputs: HashSet<PathBuf> = inputs.into_iter().flat_map(fs::canonicalize).collect();
    for output in outputs {
        let output = output.as_ref();
        let place = Place::of(output)
            .and_then(|place| place.check().map(|()| place))
            .with_context(|| format!("{}: cannot be written", output.display()))?;
        let Place::Regular(path) = place else {
            continue;
        };
        let whole = whole_path(&path);
        if inputs.contains(&whole) {
            bail!(
                "{}: this is an input of the same command, which would be lost: give another name",
                output.display()
            );
        }
        if !seen.insert(whole) {
            bail!("{}: two outputs have this name", output.display());
        }
    }
    Ok(())
}

/// Makes `folder` and keeps other processes of this program from writing into it as well, for as long
/// as the file is open: also where this one is killed.
pub fn lock_folder(folder: &Path) -> anyhow::Result<File> {
    let cannot = || format!("{}: cannot be written to", folder.display());
    fs::create_dir_all(folder).with_context(cannot)?;
    let open = File::open(folder).with_context(cannot)?;
    match open.try_lock() {
        // A file system without locks keeps nobody out.
        Ok(()) | Err(fs::TryLockError::Error(_)) => Ok(open),
        Err(fs::TryLockError::WouldBlock) => bail!(
            "{}: another capture is writing into this folder: give another one",
            folder.display()
        ),
    }
}

/// Whether two files are in one folder.
pub fn are_beside(files: [&Path; 2]) -> bool {
    let [a, b] = files.map(|file| fs::canonicalize(folder_of(file)).ok());
    a.is_some() && a == b
}

/// The rig's file and the files that it names.
pub fn rig_inputs(path: &Path) -> Vec<PathBuf> {
    let mut files = vec![path.to_owned()];
    files.extend(Rig::named_files(path));
    files
}

/// The path of a file that may not be there yet, with its folder's links resolved.
fn whole_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default();
    fs::canonicalize(folder_of(path)).map_or_else(|_| path.to_owned(), |folder| folder.join(name))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Where an output goes.
enum Place {
    /// A regular file, there or not: the path behind all symbolic links.
    Regular(PathBuf),
    /// A device, a FIFO or a socket.
    Through(PathBuf),
}

impl Place {
    fn of(path: &Path) -> anyhow::Result<Self> {
        // Names such as /dev/stdout are the process's own, whatever is behind them.
        let is_own = path.starts_with("/dev") || path.starts_with("/proc");
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => bail!("it is a folder"),
            Ok(found) if is_own || !found.is_file() => Ok(Self::Through(path.to_owned())),
            Ok(_) => Ok(Self::Regular(fs::canonicalize(path)?)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                // A link to nothing yet names the file to be made.
                match fs::read_link(path) {
                    Ok(target) => Self::of(&folder_of(path).join(target)),
                    Err(_) => Ok(Self::Regular(path.to_owned())),
                }
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether it can be written.
    fn check(&self) -> anyhow::Result<()> {
        match self {
            Self::Regular(path) => {
                // Folders are made when there is something to put into them.
                let there = folder_of(path).ancestors().find(|folder| folder.exists());
                let there = there.filter(|folder| !folder.as_os_str().is_empty());
                temporary_in(there.unwrap_or(Path::new("."))).map(drop)
            }
            // Opening a FIFO would wait for its reader.
            Self::Through(_) => Ok(()),
        }
    }
}

/// A temporary file in the folder of `path`; it goes away when dropped. Makes the folder.
fn temporary_for(path: &Path) -> anyhow::Result<NamedTempFile> {
    let folder = folder_of(path);
    fs::create_dir_all(folder)?;
    temporary_in(folder)
}

fn temporary_in(folder: &Path) -> anyhow::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: readable by others, less what the umask takes.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    Ok(builder.prefix(TEMPORARY).tempfile_in(folder)?)
}

/// An output whose bytes are complete and that does not have its name yet.
enum Pending<'a> {
    Regular(NamedTempFile, PathBuf),
    Through(PathBuf, &'a [u8]),
}

impl<'a> Pending<'a> {
    fn new(path: &Path, bytes: &'a [u8]) -> anyhow::Result<Self> {
        match Place::of(path)? {
            Place::Through(path) => Ok(Self::Through(path, bytes)),
            Place::Regular(path) => {
                let mut file = temporary_for(&path)?;
                if let Ok(before) = fs::metadata(&path) {
                    file.as_file().set_permissions(before.permissions())?;
                }
                file.write_all(bytes)?;
                file.as_file().sync_all()?;
                Ok(Self::Regular(file, path))
            }
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Regular(file, path) => {
                file.persist(&path)?;
                // The new name itself; a file system that cannot sync a folder is no error.
                if let Ok(folder) = File::open(folder_of(&path)) {
                    let _ = folder.sync_all();
                }
            }
            Self::Through(path, bytes) => {
                let mut file = OpenOptions::new().write(true).open(path)?;
                file.write_all(bytes)?;
                file.flush()?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [&str; 0] = [];

    fn text(path: &Path) -> String {
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn a_link_is_followed_and_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("there"), b"old").unwrap();
        std::os::unix::fs::symlink("there", at("link")).unwrap();
        std::os::unix::fs::symlink("later", at("dangling")).unwrap();
        write(&at("link"), b"new").unwrap();
        write(&at("dangling"), b"made").unwrap();
        assert!(at("link").is_symlink() && at("dangling").is_symlink());
        assert_eq!([text(&at("there")), text(&at("later"))], ["new", "made"]);
        std::os::unix::fs::symlink("loop", at("loop")).unwrap();
        assert!(write(&at("loop"), b"x").is_err());
    }

    #[test]
    fn a_fifo_and_a_device_are_written_through() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let fifo = folder.path().join("fifo");
        let made = std::process::Command::new("mkfifo").arg(&fifo).status();
        assert!(made.unwrap().success());
        let reader = std::thread::spawn({
            let fifo = fifo.clone();
            move || fs::read(fifo).unwrap()
        });
        check_outputs([&fifo], NONE).unwrap();
        write(&fifo, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::symlink_metadata(&fifo).unwrap().file_type().is_fifo());
        let null = Path::new("/dev/null");
        write(null, b"gone").unwrap();
        assert!(fs::metadata(null).unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_group_is_replaced_as_one_or_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), b"old a").unwrap();
        fs::create_dir(at("b")).unwrap();
        let error = write_group(&[(&at("a"), b"new a"), (&at("b"), b"new b")]).unwrap_err();
        assert!(format!("{error:#}").contains("it is a folder"), "{error:#}");
        assert_eq!(text(&at("a")), "old a");
        // Nothing temporary stays behind.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_folder_is_written_to_by_one_capture_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new");
        let first = lock_folder(&folder).unwrap();
        let refused = lock_folder(&folder).unwrap_err();
        assert!(
            refused.to_string().contains("another capture"),
            "{refused:#}"
        );
        drop(first);
        lock_folder(&folder).unwrap();
    }

    #[test]
    fn an_output_that_is_an_input_or_another_output_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("rig.toml"), b"rig").unwrap();
        std::os::unix::fs::symlink("rig.toml", at("link")).unwrap();
        let dotted = folder.path().join(".").join("rig.toml");
        for output in [at("rig.toml"), at("link"), dotted] {
            let error = check_outputs([&output], [&at("rig.toml")]).unwrap_err();
            assert!(error.to_string().contains("input"), "{error:#}");
        }
        let twice = check_outputs([at("x"), at("x")], NONE).unwrap_err();
        assert!(twice.to_string().contains("two outputs"), "{twice:#}");
        check_outputs([at("x"), at("y")], [at("rig.toml")]).unwrap();
    }
}
