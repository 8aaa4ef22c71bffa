//! What is plugged in.

use std::path::{Path, PathBuf};

use super::negotiate;

/// A device node that is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Node, such as `/dev/video0`; changes with the order of plugging in.
    pub node: PathBuf,
    /// Names that stay: by the camera's own number first, then by the port it is in.
    pub stable_names: Vec<PathBuf>,
    /// What it calls itself; empty where it cannot be used.
    pub product: String,
    /// Formats with sizes and their rates, a line each.
    pub offered: String,
    /// Why it cannot be used, for a node that cannot.
    pub unusable: Option<String>,
}

/// All video nodes: cameras, and what cannot be used as one with the reason.
pub fn list() -> Vec<Listed> {
    let mut nodes: Vec<PathBuf> = entries(Path::new("/dev"))
        .into_iter()
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.strip_prefix("video")
                .is_some_and(|n| n.parse::<u32>().is_ok())
        })
        .collect();
    nodes.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    nodes
        .into_iter()
        .map(|node| {
            let described = negotiate::description(&node);
            let unusable = described.as_ref().err().map(ToString::to_string);
            let (product, offered) = described.unwrap_or_default();
            Listed {
                stable_names: stable_names(&node),
                node,
                product,
                offered,
                unusable,
            }
        })
        .collect()
}

/// Names of a device node in `/dev/v4l` that stay the same over unplugging.
pub fn stable_names(node: &Path) -> Vec<PathBuf> {
    ["/dev/v4l/by-id", "/dev/v4l/by-path"]
        .into_iter()
        .flat_map(|folder| {
            let mut names = entries(Path::new(folder));
            names.sort();
            names
        })
        .filter(|name| name.canonicalize().is_ok_and(|target| target == node))
        .collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect()
}
