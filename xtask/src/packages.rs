//! Debian packages that steps need: installed where that was asked for, else named.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A package, and how to tell that it is there.
#[derive(Clone, Copy, Debug)]
pub struct Need {
    /// A file that is there once the package is.
    pub file: &'static str,
    /// The package.
    pub package: &'static str,
}

const fn need(file: &'static str, package: &'static str) -> Need {
    Need { file, package }
}

/// For the tests of the preview's page.
pub const BROWSER: &[Need] = &[need("/usr/bin/chromium", "chromium")];

/// A compiler with the sources of `core`, for boards.
pub const BOARD_COMPILER: &[Need] = &[
    need("/usr/bin/rustc", "rustc-web"),
    need("/usr/bin/cargo", "cargo-web"),
    need("/usr/lib/rustlib/src/rust/library/core", "rust-web-src"),
    need("/usr/bin/ld.lld", "lld"),
];

/// The emulator of boards.
pub const BOARD_EMULATOR: &[Need] = &[need("/usr/bin/qemu-system-arm", "qemu-system-arm")];

/// Compiler, libraries and emulator for aarch64.
pub const AARCH64: &[Need] = &[
    need("/usr/bin/rustc", "rustc-web"),
    need("/usr/bin/cargo", "cargo-web"),
    need(
        "/usr/lib/rustlib/aarch64-unknown-linux-gnu/lib",
        "libstd-rust-web-dev:arm64",
    ),
    need("/usr/bin/aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu"),
    need(
        "/usr/aarch64-linux-gnu/lib/libc.so.6",
        "libc6-dev-arm64-cross",
    ),
    need("/usr/bin/qemu-aarch64", "qemu-user"),
];

/// What building with cameras needs.
pub const CAMERA_BUILD: &[Need] = &[need("/usr/share/doc/libclang-dev", "libclang-dev")];

/// The emulated machine with the kernel's virtual cameras.
pub const CAMERA_MACHINE: &[Need] = &[
    need("/usr/bin/qemu-system-x86_64", "qemu-system-x86"),
    need("/usr/bin/cpio", "cpio"),
    need("/usr/bin/kmod", "kmod"),
    need("/usr/bin/v4l2-ctl", "v4l-utils"),
    need("/usr/share/doc/busybox-static", "busybox-static"),
];

/// Whether all of `needs` are there.
pub fn are_there(needs: &[Need]) -> bool {
    missing(needs).is_empty()
}

/// The packages of `needs` that are not there.
pub fn missing(needs: &[Need]) -> Vec<&'static str> {
    needs
        .iter()
        .filter(|need| !Path::new(need.file).exists())
        .map(|need| need.package)
        .collect()
}

/// What to do for `needs`: one line for a terminal.
pub fn advice(needs: &[Need]) -> String {
    let missing = missing(needs);
    let foreign = missing.iter().any(|package| package.ends_with(":arm64"));
    let first = if foreign {
        "`dpkg --add-architecture arm64`, `apt-get update` and "
    } else {
        ""
    };
    format!("as root {first}`apt-get install {}`", missing.join(" "))
}

/// Installs what is missing of `needs`, if `allowed` and possible, after saying so; otherwise one
/// line says what to install.
pub fn install(needs: &[Need], allowed: bool) {
    let mut missing = missing(needs);
    missing.dedup();
    if missing.is_empty() {
        println!("all Debian packages are there");
        return;
    }
    if !allowed || !is_root() || find_program("apt-get").is_none() {
        println!(
            "some steps will be skipped; to run them: {} (or `cargo xtask test --install` as root)",
            advice(needs)
        );
        return;
    }
    println!("installing Debian packages: {}", missing.join(" "));
    if missing.iter().any(|package| package.ends_with(":arm64")) {
        run("dpkg", &["--add-architecture", "arm64"]);
    }
    run("apt-get", &["update", "-q"]);
    let mut install = vec!["install", "-y", "-q", "--no-install-recommends"];
    install.extend(&missing);
    run("apt-get", &install);
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
