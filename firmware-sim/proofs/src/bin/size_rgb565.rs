//! Check of a table and all of the stitcher for Rgb565.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; 64] = [0; 64];
    tectum_proofs::stitch::<tectum_core::Rgb565>(ROOM);
    exit_success()
}
