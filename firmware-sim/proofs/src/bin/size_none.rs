//! Start-up alone: what the other sizes are counted from.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    tectum_proofs::nothing();
    exit_success()
}
