//! Check of a table and the look-up of directions.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    tectum_proofs::lookup();
    exit_success()
}
