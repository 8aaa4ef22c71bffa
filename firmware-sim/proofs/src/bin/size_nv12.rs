//! Check of a table and all of the stitchers for both planes of NV12.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; 64] = [0; 64];
    tectum_proofs::nv12(ROOM);
    exit_success()
}
