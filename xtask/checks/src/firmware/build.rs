//! Builds of the firmware workspace.

use std::path::PathBuf;
use std::process::Output;

use anyhow::{Context, bail};

use super::board::Board;
use super::toolchain::Toolchain;
use super::workspace;
use xtask::target_dir;

/// A compiler and the board it builds for.
#[derive(Clone, Copy, Debug)]
pub struct Builder {
    /// The compiler in use.
    pub toolchain: Toolchain,
    /// The board.
    pub board: Board,
}

impl Builder {
    /// Builds all programs of a package in release mode; an error carries the compiler's text.
    pub fn build(self, package: &str) -> anyhow::Result<()> {
        println!(
            "{}: building {package} with {}",
            self.board.name(),
            self.toolchain.version()
        );
        let output = self.output(&["-p", package, "--bins"])?;
        if !output.status.success() {
            bail!(
                "building {package}:\n{}",
                String::from_utf8_lossy(&output.stderr).trim_end()
            );
        }
        Ok(())
    }

    /// Runs `cargo build` with more arguments and keeps what it prints.
    pub fn output(self, arguments: &[&str]) -> anyhow::Result<Output> {
        let settings = format!("boards/{}.toml", self.board.name());
        self.toolchain
            .cargo(self.board, "build")
            .args(["--quiet", "--locked", "--release", "--config", &settings])
            .arg("--target-dir")
            .arg(self.folder())
            .args(arguments)
            .current_dir(workspace())
            .output()
            .context("starting cargo")
    }

    /// Where the program of that name lies until another board is built.
    pub fn program(self, name: &str) -> PathBuf {
        self.folder()
            .join(self.board.target())
            .join("release")
            .join(name)
    }

    /// One for all boards: what runs on this machine while building is then built once.
    fn folder(self) -> PathBuf {
        target_dir("firmware")
    }
}
