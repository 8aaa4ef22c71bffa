//! The compiler for the boards: the active one if it has the targets, else Debian's.

use std::path::Path;
use std::process::Command;

use super::board::Board;
use crate::packages::{self, Need};

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_COMPILER: &[Need] = &[
    Need {
        file: DEBIAN_RUSTC,
        package: "rustc-web",
    },
    Need {
        file: "/usr/bin/cargo",
        package: "cargo-web",
    },
    Need {
        file: "/usr/lib/rustlib/src/rust/library/core",
        package: "rust-web-src",
    },
    Need {
        file: "/usr/bin/ld.lld",
        package: "lld",
    },
];
const QEMU: Need = Need {
    file: "/usr/bin/qemu-system-arm",
    package: "qemu-system-arm",
};

/// A compiler that can build for the boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The active one: its target libraries are installed.
    Active,
    /// Debian's, which builds `core` from its sources.
    Debian,
}

impl Toolchain {
    /// Finds or installs a compiler for `boards`, and QEMU; else one line that says what to do.
    pub fn find(boards: &[Board]) -> Result<Self, String> {
        let lacking: Vec<&str> = lacking_targets(boards);
        let active = lacking.is_empty();
        let have_qemu =
            packages::find_program("qemu-system-arm").is_some() || packages::ensure(&[QEMU], None);
        let have_compiler = active || packages::ensure(DEBIAN_COMPILER, None);
        match (have_qemu, have_compiler) {
            (true, true) if active => Ok(Self::Active),
            (true, true) => Ok(Self::Debian),
            (true, false) => Err(format!(
                "no compiler for the boards: `rustup target add {}`, or as root `apt-get install {}`",
                lacking.join(" "),
                packages::names(DEBIAN_COMPILER)
            )),
            (false, _) => Err(format!(
                "no emulator and maybe no compiler: install QEMU's qemu-system-arm and `rustup target \
                 add {}`, or as root `apt-get install {} {}`",
                lacking.join(" "),
                QEMU.package,
                packages::names(DEBIAN_COMPILER)
            )),
        }
    }

    /// A cargo command for `board`, without a subcommand's own arguments.
    pub fn cargo(self, board: Board, subcommand: &str) -> Command {
        let mut cargo = match self {
            Self::Active => Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into())),
            Self::Debian => debian_cargo(),
        };
        // Flags from outside would replace those of the board.
        for variable in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
            cargo.env_remove(variable);
        }
        cargo.arg(subcommand);
        if self == Self::Debian {
            let target = board.target().to_uppercase().replace(['-', '.'], "_");
            cargo.env(format!("CARGO_TARGET_{target}_LINKER"), "ld.lld");
            cargo.env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=core");
        }
        cargo
    }

    /// "rustc 1.96.0": figures depend on it.
    pub fn version(self) -> String {
        let rustc = match self {
            Self::Active => "rustc",
            Self::Debian => DEBIAN_RUSTC,
        };
        let text = stdout(Command::new(rustc).arg("--version")).unwrap_or_default();
        text.split_whitespace()
            .take(2)
            .collect::<Vec<_>>()
            .join(" ")
    }
}

/// Debian's cargo with Debian's compiler, whatever toolchain started this program.
pub fn debian_cargo() -> Command {
    let mut cargo = Command::new("/usr/bin/cargo");
    cargo
        .env("RUSTC", DEBIAN_RUSTC)
        .env("RUSTDOC", "/usr/bin/rustdoc");
    for variable in ["RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "CARGO", "RUSTFLAGS"] {
        cargo.env_remove(variable);
    }
    cargo
}

/// Targets of `boards` that the active compiler has no libraries for.
fn lacking_targets(boards: &[Board]) -> Vec<&'static str> {
    let sysroot = stdout(Command::new("rustc").args(["--print", "sysroot"])).unwrap_or_default();
    let libraries = Path::new(sysroot.trim()).join("lib/rustlib");
    let mut lacking: Vec<&str> = boards
        .iter()
        .map(|board| board.target())
        .filter(|target| !libraries.join(target).join("lib").is_dir())
        .collect();
    lacking.dedup();
    lacking
}

fn stdout(command: &mut Command) -> Option<String> {
    let output = command.output().ok()?;
    String::from_utf8(output.stdout).ok()
}
