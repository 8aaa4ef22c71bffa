//! The emulated boards.

use clap::ValueEnum;

/// An emulated board. Its compiler flags are in `firmware-sim/boards/NAME.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Cortex-M4 (MPS2 AN386)
    M4,
    /// Cortex-M7 (MPS2 AN500)
    M7,
    /// Cortex-M55 with Helium (MPS3 AN547)
    M55,
}

impl Board {
    /// Name in file names and in `TECTUM_BOARD`.
    pub fn name(self) -> &'static str {
        match self {
            Self::M4 => "m4",
            Self::M7 => "m7",
            Self::M55 => "m55",
        }
    }

    /// Compiler target.
    pub fn target(self) -> &'static str {
        match self {
            Self::M4 | Self::M7 => "thumbv7em-none-eabihf",
            Self::M55 => "thumbv8m.main-none-eabihf",
        }
    }

    /// `-cpu` and `-machine` of QEMU.
    pub fn qemu(self) -> (&'static str, &'static str) {
        match self {
            Self::M4 => ("cortex-m4", "mps2-an386"),
            Self::M7 => ("cortex-m7", "mps2-an500"),
            Self::M55 => ("cortex-m55", "mps3-an547"),
        }
    }
}
