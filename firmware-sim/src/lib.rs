//! What every program shares: tables and frames in flash, the log over semihosting, and the panic
//! handler.
#![no_std]

pub mod data;

use core::fmt::Display;
use core::panic::PanicInfo;

use defmt_semihosting as _;

/// Logs one line.
pub fn log(line: &dyn Display) {
    defmt::println!("{}", defmt::Display2Format(line));
}

/// Reports the panic on the log and ends the emulation with exit code 1.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    tectum_board::exit_failure()
}
