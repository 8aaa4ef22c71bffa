//! `cargo xtask cameras`: the built program with virtual cameras of the Linux kernel (vivid), in an
//! emulated machine.

mod frames;
mod image;
mod judge;
mod machine;

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, bail};

use crate::firmware::target_dir;
use crate::packages::{self, Need};
use crate::repository;
use crate::steps::Outcome;

const NEEDS: &[Need] = &[
    Need {
        file: "/usr/bin/qemu-system-x86_64",
        package: "qemu-system-x86",
    },
    Need {
        file: "/usr/bin/cpio",
        package: "cpio",
    },
    Need {
        file: "/usr/bin/kmod",
        package: "kmod",
    },
    Need {
        file: "/usr/bin/v4l2-ctl",
        package: "v4l-utils",
    },
    Need {
        file: "/usr/share/doc/busybox-static",
        package: "busybox-static",
    },
    Need {
        file: "/usr/share/doc/libclang-dev",
        package: "libclang-dev",
    },
];

/// Builds, boots, reads what the machine says.
pub fn run() -> anyhow::Result<Outcome> {
    if cfg!(not(target_arch = "x86_64")) {
        return Ok(Outcome::Skipped(
            "the emulated machine is an x86-64".to_owned(),
        ));
    }
    if !packages::ensure(NEEDS, None) {
        let why = format!("as root `apt-get install {}`", packages::names(NEEDS));
        return Ok(Outcome::Skipped(why));
    }
    let folder = target_dir("cameras");
    let kernel = match image::kernel(&folder) {
        Ok(kernel) => kernel,
        Err(error) => {
            let why = format!("Debian's kernel package cannot be had: {error:#}");
            return Ok(Outcome::Skipped(why));
        }
    };
    let program = build()?;
    let frames = frames::prepare(&folder)?;
    let initramfs = image::initramfs(&folder, &kernel, &program, &frames)?;
    let said = machine::boot(&kernel.file, &initramfs)?;
    judge::judge(&said)?;
    Ok(Outcome::Passed)
}

/// Builds the program with cameras, and runs the tests that come with them.
fn build() -> anyhow::Result<PathBuf> {
    for arguments in [
        &["build", "-p", "tectum"][..],
        &["test", "-p", "tectum-capture", "--lib"],
    ] {
        let mut cargo = Command::new("cargo");
        cargo
            .args(arguments)
            .args(["--quiet", "--features", "v4l2"]);
        let status = cargo.current_dir(repository()).status().context("cargo")?;
        if !status.success() {
            bail!("cargo {} --features v4l2", arguments.join(" "));
        }
    }
    Ok(target_dir("debug").join("tectum"))
}
