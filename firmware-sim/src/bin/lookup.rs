//! Asks for directions and pixels over a grid, makes targets of boxes, and logs CRC-32s of the
//! answers, which the host must repeat.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};
use tectum_core::Tables;
use tectum_firmware_sim::{data, log};
use tectum_fixture::queries;

#[entry]
fn main() -> ! {
    let tables = defmt::unwrap!(Tables::parse(data::PICTURE));
    queries::run(&tables, |line| log(line));
    exit_success()
}
