//! Debian's Rust compiler, which builds for processors that the active toolchain may have no
//! libraries for.

use std::process::Command;

/// Its path.
pub const RUSTC: &str = "/usr/bin/rustc";

/// Debian's cargo with Debian's compiler, whatever toolchain started this program.
pub fn cargo() -> Command {
    let mut cargo = Command::new("/usr/bin/cargo");
    cargo.env("RUSTC", RUSTC).env("RUSTDOC", "/usr/bin/rustdoc");
    for variable in ["RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "CARGO", "RUSTFLAGS"] {
        cargo.env_remove(variable);
    }
    cargo
}
