//! Stitches random tables in every format and compares CRC-32s with those of the host's core, whose loops
//! are the portable ones.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};
use tectum_core::Tables;
use tectum_firmware_sim::{data, log};
use tectum_fixture::random;

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; data::ROOM_BYTES] = [0; data::ROOM_BYTES];
    let mut rest = data::RANDOM;
    let (mut tables, mut different) = (0, 0);
    while let Some(([crc, length], bytes)) = header(rest) {
        let (table, later) = defmt::unwrap!(bytes.split_at_checked(length as usize));
        let table = defmt::unwrap!(Tables::parse(table));
        let found = random::checksum(&table, data::frames, ROOM).expect("the core refused the job");
        if found != crc {
            log(&format_args!("table {tables} differs"));
            different += 1;
        }
        tables += 1;
        rest = later;
    }
    log(&format_args!(
        "{tables} random tables, {different} different"
    ));
    exit_success()
}

/// The two numbers that a table begins with, and the rest.
fn header(bytes: &[u8]) -> Option<([u32; 2], &[u8])> {
    let (numbers, rest) = bytes.split_first_chunk::<8>()?;
    let [a, b, c, d, e, f, g, h] = *numbers;
    Some(([[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes), rest))
}
