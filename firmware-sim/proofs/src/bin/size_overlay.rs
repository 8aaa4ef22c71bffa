//! Check of a table, and scales drawn in Yuyv.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; 64] = [0; 64];
    tectum_proofs::overlay::<tectum_core::Yuyv>(ROOM);
    exit_success()
}
