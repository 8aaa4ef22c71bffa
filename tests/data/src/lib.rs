//! Where tests find real pictures, which are not part of the repository, and how a test says that
//! it has nothing to do.

use std::io::Write;
use std::path::{Path, PathBuf};

/// The repository's top folder.
pub fn repository() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package)
}

/// A file or folder of the data sets that lie beside a checkout in `../shared/data`. `None` where
/// it is not there: the test that asked then has nothing to do, and [`skip`] has said so.
pub fn data(set: &str) -> Option<PathBuf> {
    let path = repository().join("../shared/data").join(set);
    if path.exists() {
        return Some(path);
    }
    skip(&format!("{set} is not in ../shared/data"));
    None
}

/// Says that the running test has nothing to do. Rust's test harness would count it as passed and
/// hide what it prints; `cargo xtask test` counts this line, which goes round the harness.
pub fn skip(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let line = format!("skipped: {test}: {why}\n");
    // Nobody would see a failure of this either.
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}
