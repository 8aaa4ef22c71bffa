//! Stack that the core takes at most.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success, high_water_bytes};
use tectum_core::{
    BinaryAngle, Chroma420, Direction, Exposure, Eye, Gray8, Lookup, Meter, Painter, PixelFormat,
    Rgb8, Rgb565, Rgb565Be, StitchError, Stitcher, Tables, Targets, Tone, Uyvy, Yuyv,
};
use tectum_firmware_sim::{data, log};
use tectum_fixture::boxes::{self, BOXES, TOLERANCE};
use tectum_fixture::frames::Layout;
use tectum_fixture::job::{SAMPLERS, pair};
use tectum_fixture::overlay::draw;

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; data::ROOM_BYTES] = [0; data::ROOM_BYTES];
    let (bytes, tables) = high_water_bytes(|| Tables::parse(data::PICTURE));
    let tables = defmt::unwrap!(tables);
    log(&format_args!("parse {bytes} bytes"));
    measure::<Gray8>(&tables, ROOM, Layout::Gray8);
    measure::<Rgb565>(&tables, ROOM, Layout::Rgb565);
    measure::<Rgb565Be>(&tables, ROOM, Layout::Rgb565);
    measure::<Yuyv>(&tables, ROOM, Layout::Yuyv);
    measure::<Uyvy>(&tables, ROOM, Layout::Yuyv);
    measure::<Chroma420>(&tables, ROOM, Layout::Gray8);
    measure::<Rgb8>(&tables, ROOM, Layout::Rgb8);
    measure_exposure();
    measure_scales(ROOM);
    measure_lookup(&tables);
    measure_targets(&tables);
    for (what, bytes) in [
        ("Tables", size_of::<Tables>()),
        ("Meter", size_of::<Meter>()),
        ("Exposure", size_of::<Exposure>()),
        ("Tone", size_of::<Tone<Yuyv>>()),
        ("Targets of 16 boxes", size_of::<Targets<'_, BOXES>>()),
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

/// Scales over a picture.
fn measure_scales(room: &mut [u8]) {
    let tables = defmt::unwrap!(Tables::parse(data::SCALED));
    let overlay = defmt::unwrap!(tables.overlay());
    let row_bytes = usize::from(tables.output_width_px()) * Yuyv::BYTES_PER_PIXEL;
    let picture = &mut room[..row_bytes * usize::from(tables.output_height_px())];
    let (bytes, result) =
        high_water_bytes(|| draw(&Painter::<Yuyv>::new(overlay), picture, row_bytes));
    defmt::unwrap!(result);
    log(&format_args!("scales {bytes} bytes"));
}

/// Queries of each kind.
fn measure_lookup(tables: &Tables) {
    let lookup = Lookup::new(tables);
    let direction = Direction {
        yaw: BinaryAngle(9000),
        pitch: BinaryAngle(-4000),
    };
    let (bytes, answers) = high_water_bytes(|| {
        let pixels = [
            lookup.pixel_of_direction(direction),
            lookup.eye_pixel_of_direction(Eye::Left, direction),
        ];
        let directions = [
            pixels[0].and_then(|pixel| lookup.direction_of_pixel(pixel)),
            pixels[1].and_then(|pixel| lookup.direction_of_eye_pixel(Eye::Left, pixel)),
        ];
        directions.into_iter().flatten().count()
    });
    defmt::assert!(answers == 2);
    log(&format_args!("lookup {bytes} bytes"));
}

/// Boxes taken and merged; the list of boxes is the caller's and counted apart.
fn measure_targets(tables: &Tables) {
    let mut targets = Targets::<BOXES>::new(tables);
    let (bytes, merged) = high_water_bytes(|| {
        boxes::add(&mut targets, boxes::boxes(tables))?;
        Ok::<_, tectum_core::TargetError>(targets.merged(TOLERANCE).len())
    });
    defmt::assert!(defmt::unwrap!(merged) > 0);
    log(&format_args!("targets {bytes} bytes"));
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
