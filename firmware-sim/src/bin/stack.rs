//! Stack that the core takes at most.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success, high_water_bytes};
use tectum_core::{
    Exposure, Eye, Gray8, Meter, PixelFormat, Rgb8, Rgb565, StitchError, Stitcher, Tables, Tone,
    Yuyv,
};
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
    measure_exposure();
    for (what, bytes) in [
        ("Tables", size_of::<Tables>()),
        ("Meter", size_of::<Meter>()),
        ("Exposure", size_of::<Exposure>()),
        ("Tone", size_of::<Tone<Yuyv>>()),
    ] {
        log(&format_args!("{what} {bytes} bytes"));
    }
    exit_success()
}

/// Metering, gains and curves; the state is the caller's and counted apart.
fn measure_exposure() {
    let tables = defmt::unwrap!(Tables::parse(data::TONED));
    let frames = data::frames(Layout::Yuyv);
    let [left, right] = pair::<Yuyv>(&tables, frames).expect("wrong frames");
    let (mut meter, mut exposure) = (Meter::new(), Exposure::new(Exposure::USUAL_RATE));
    let mut tone = Tone::<Yuyv>::new(&tables, exposure.gains());
    let (bytes, result) = high_water_bytes(|| {
        meter.read(&tables, Eye::Left, &left)?;
        meter.read(&tables, Eye::Right, &right)?;
        exposure.update(&meter);
        tone.set(&tables, exposure.gains());
        Ok::<_, StitchError>(())
    });
    defmt::unwrap!(result);
    log(&format_args!("exposure {bytes} bytes"));
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
