//! Debian packages: installed where that is possible, else named.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a step needs and which package brings it.
pub struct Need {
    /// A file that is there once the package is.
    pub file: &'static str,
    /// The package.
    pub package: &'static str,
}

/// Whether all of `needs` are there, after an attempt to install what is missing. Prints what it
/// does.
pub fn ensure(needs: &[Need], architecture: Option<&str>) -> bool {
    let missing: Vec<&str> = missing(needs);
    if missing.is_empty() {
        return true;
    }
    if !is_root() || find_program("apt-get").is_none() {
        return false;
    }
    println!("installing Debian packages: {}", missing.join(" "));
    if let Some(architecture) = architecture {
        run("dpkg", &["--add-architecture", architecture]);
    }
    run("apt-get", &["update", "-q"]);
    let mut install = vec!["install", "-y", "-q", "--no-install-recommends"];
    install.extend(&missing);
    run("apt-get", &install);
    self::missing(needs).is_empty()
}

/// Packages of `needs` whose file is not there.
fn missing(needs: &[Need]) -> Vec<&'static str> {
    needs
        .iter()
        .filter(|need| !Path::new(need.file).exists())
        .map(|need| need.package)
        .collect()
}

/// The package names, for a message.
pub fn names(needs: &[Need]) -> String {
    needs
        .iter()
        .map(|need| need.package)
        .collect::<Vec<_>>()
        .join(" ")
}

/// First program of that name on the path.
pub fn find_program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|dir| dir.join(name))
        .find(|file| file.is_file())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

/// A failure shows in the files that stay missing, and on the terminal.
fn run(program: &str, arguments: &[&str]) {
    let status = Command::new(program)
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdout(Stdio::null())
        .status();
    if !status.is_ok_and(|status| status.success()) {
        eprintln!("`{program} {}` failed", arguments.join(" "));
    }
}
