//! What the chores share: where things are, how a step ends, Debian's packages.

pub mod debian;
pub mod packages;

use std::path::{Path, PathBuf};

/// How a step ended, if not in an error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All went well.
    Passed,
    /// Not possible here; says what is missing.
    Skipped(String),
}

/// Exit code of a check that is not possible here; its last line is [`SKIPPED`] and the reason.
pub const SKIPPED_EXIT_CODE: u8 = 77;

/// What a line begins with that says what was skipped and why.
pub const SKIPPED: &str = "skipped: ";

/// The repository's top folder.
pub fn repository() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}

/// The target folder in use.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || repository().join("target"),
        |dir| repository().join(PathBuf::from(dir)),
    )
}

/// A folder for products of a build of its own, inside the target folder in use.
pub fn target_dir(name: &str) -> PathBuf {
    target().join(name)
}
