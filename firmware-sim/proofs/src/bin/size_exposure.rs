//! Check of a table, metering, gains and curves for Yuyv.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    tectum_proofs::exposure::<tectum_core::Yuyv>();
    exit_success()
}
