//! What the programs need of an emulated board: a memory map (`memory/*.x`), start-up and FPU (by
//! `cortex-m-rt`), an instruction counter, a stack high-water mark and an exit code.
#![no_std]

mod counter;
mod stack;

pub use cortex_m_rt::entry;
pub use counter::Counter;
pub use stack::high_water_bytes;

// The crate is linked for its critical section, which defmt asks for by symbol.
use cortex_m as _;

/// Ends the emulation; the process exit code is 0.
pub fn exit_success() -> ! {
    semihosting::process::exit(0)
}

/// Ends the emulation; the process exit code is 1.
pub fn exit_failure() -> ! {
    semihosting::process::exit(1)
}
