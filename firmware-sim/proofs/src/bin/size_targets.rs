//! Check of a table, and targets of boxes.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    tectum_proofs::targets();
    exit_success()
}
