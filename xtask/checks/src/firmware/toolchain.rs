//! The compiler for the boards: the active one if it has the targets, else Debian's.

use std::path::Path;
use std::process::Command;

use super::board::Board;
use xtask::debian;
use xtask::packages::{self, BOARD_COMPILER, BOARD_EMULATOR};

/// A compiler that can build for the boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The active one: its target libraries are installed.
    Active,
    /// Debian's, which builds `core` from its sources.
    Debian,
}

impl Toolchain {
    /// Finds a compiler for `boards`, and QEMU; else one line that says what to install.
    pub fn find(boards: &[Board]) -> Result<Self, String> {
        let lacking = lacking_targets(boards);
        let toolchain = if lacking.is_empty() {
            Self::Active
        } else {
            Self::Debian
        };
        let mut advice = Vec::new();
        if toolchain == Self::Debian && !packages::are_there(BOARD_COMPILER) {
            advice.push(format!(
                "no compiler for the boards: `rustup target add {}`, or {}",
                lacking.join(" "),
                packages::advice(BOARD_COMPILER)
            ));
        }
        if packages::find_program("qemu-system-arm").is_none() {
            let advised = packages::advice(BOARD_EMULATOR);
            advice.push(format!("no emulator of the boards: {advised}"));
        }
        if advice.is_empty() {
            Ok(toolchain)
        } else {
            Err(advice.join("; "))
        }
    }

    /// A cargo command for `board`, without a subcommand's own arguments.
    pub fn cargo(self, board: Board, subcommand: &str) -> Command {
        let mut cargo = match self {
            Self::Active => Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into())),
            Self::Debian => debian::cargo(),
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
            Self::Debian => debian::RUSTC,
        };
        let text = stdout(Command::new(rustc).arg("--version")).unwrap_or_default();
        text.split_whitespace()
            .take(2)
            .collect::<Vec<_>>()
            .join(" ")
    }
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
