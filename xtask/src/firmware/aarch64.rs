//! `cargo xtask aarch64`: the tests of the core on the SoC side's processor, emulated.

use anyhow::{Context, bail};

use super::{repository, target_dir, toolchain};
use crate::packages::{self, Need};
use crate::steps::Outcome;

const TARGET: &str = "aarch64-unknown-linux-gnu";
const NEEDS: &[Need] = &[
    Need {
        file: "/usr/bin/rustc",
        package: "rustc-web",
    },
    Need {
        file: "/usr/bin/cargo",
        package: "cargo-web",
    },
    Need {
        file: "/usr/lib/rustlib/aarch64-unknown-linux-gnu/lib",
        package: "libstd-rust-web-dev:arm64",
    },
    Need {
        file: "/usr/bin/aarch64-linux-gnu-gcc",
        package: "gcc-aarch64-linux-gnu",
    },
    Need {
        file: "/usr/aarch64-linux-gnu/lib/libc.so.6",
        package: "libc6-dev-arm64-cross",
    },
    Need {
        file: "/usr/bin/qemu-aarch64",
        package: "qemu-user",
    },
];

/// What is tested: the unit tests of tables and core, and the core against its references.
const TESTS: [&str; 11] = [
    "-p",
    "tectum-tables",
    "-p",
    "tectum-core",
    "-p",
    "tectum-tests",
    "--lib",
    "--test",
    "differential",
    "--test",
    "hostile",
];

/// Builds the tests with Debian's cross compiler and runs them under user-mode QEMU.
pub fn run() -> anyhow::Result<Outcome> {
    if !packages::ensure(NEEDS, Some("arm64")) {
        return Ok(Outcome::Skipped(format!(
            "as root `dpkg --add-architecture arm64`, `apt-get update` and \
             `apt-get install {}`",
            packages::names(NEEDS)
        )));
    }
    let mut cargo = toolchain::debian_cargo();
    cargo
        .args(["test", "--locked", "--target", TARGET, "--target-dir"])
        .arg(target_dir("aarch64"))
        .args(TESTS)
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER",
            "aarch64-linux-gnu-gcc",
        )
        // With the cross libraries of libc6-dev-arm64-cross in place of the real ones, starting a
        // thread never returns.
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER",
            "qemu-aarch64 -L /",
        )
        .current_dir(repository());
    let status = cargo.status().context("starting Debian's cargo")?;
    if !status.success() {
        bail!("tests failed on emulated aarch64");
    }
    Ok(Outcome::Passed)
}
