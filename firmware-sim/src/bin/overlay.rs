//! Draws scales over stitched rows in every format and logs CRC-32s. The host runs the same job and
//! must log the same.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};
use tectum_core::Tables;
use tectum_firmware_sim::{data, log};
use tectum_fixture::overlay;

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; data::ROOM_BYTES] = [0; data::ROOM_BYTES];
    let tables = defmt::unwrap!(Tables::parse(data::SCALED));
    overlay::run(&tables, data::frames, ROOM, |line| log(line)).expect("the core refused the job");
    exit_success()
}
