//! Check of a table.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};

#[entry]
fn main() -> ! {
    tectum_proofs::parse();
    exit_success()
}
