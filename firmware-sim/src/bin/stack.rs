//! Stack that the core takes at most.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success, high_water_bytes};
use tectum_core::{Gray8, PixelFormat, Rgb8, Rgb565, Stitcher, Tables, Yuyv};
use tectum_firmware_sim::{data, log};
use tectum_fixture::frames::Layout;
use tectum_fixture::job::{SAMPLERS, pair};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; data::ROOM_BYTES] = [0; data::ROOM_BYTES];
    let (bytes, tables) = high_water_bytes(|| Tables::parse(data::PICTURE));
    let tables = defmt::unwrap!(tables);
    log(&format_args!("parse {bytes} bytes"));
    measure::<Gray8>(&tables, ROOM, Layout::Gray8);
    measure::<Rgb565>(&tables, ROOM, Layout::Rgb565);
    measure::<Yuyv>(&tables, ROOM, Layout::Yuyv);
    measure::<Rgb8>(&tables, ROOM, Layout::Rgb8);
    log(&format_args!("Tables {} bytes", size_of::<Tables>()));
    exit_success()
}

fn measure<F: PixelFormat>(tables: &Tables, room: &mut [u8], layout: Layout) {
    let [left, right] = pair::<F>(tables, data::frames(layout)).expect("wrong frames");
    for (sampler_name, sampler) in SAMPLERS {
        let (bytes, result) = high_water_bytes(|| {
            let stitcher = Stitcher::<F>::new(tables, sampler)?;
            stitcher.frame(&left, &right, room, stitcher.row_bytes())
        });
        defmt::unwrap!(result);
        log(&format_args!("{} {sampler_name} {bytes} bytes", F::NAME));
    }
}
