//! Instructions of the core for each output pixel, by format, sampler and kind of pixel; for tone and
//! scales on top; for following exposure; for look-up and targets.
#![no_std]
#![no_main]

use tectum_board::{Counter, entry, exit_success};
use tectum_core::{
    BinaryAngle, Chroma420, Direction, Exposure, Eye, Gains, Gray8, Lookup, Meter, Painter,
    PixelFormat, Rgb8, Rgb565, Rgb565Be, Sampler, StitchError, Stitcher, Tables, Targets, Tone,
    Uyvy, Yuyv,
};
use tectum_firmware_sim::{data, log};
use tectum_fixture::boxes::{self, BOXES, TOLERANCE};
use tectum_fixture::frames::Layout;
use tectum_fixture::job::{SAMPLERS, pair};
use tectum_fixture::overlay::draw;

/// Kinds of pixels, each with a table that has no other.
const KINDS: [(&str, &[u8]); 4] = [
    ("picture", data::PICTURE),
    ("one-eye", data::ONE_EYE),
    ("blend", data::BLEND),
    ("void", data::VOID),
];

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; data::ROOM_BYTES] = [0; data::ROOM_BYTES];
    let mut counter = Counter::take();
    let (instructions, tables) = counter.instructions(|| Tables::parse(data::PICTURE));
    log_per_pixel("parse", &defmt::unwrap!(tables), instructions);
    count::<Gray8>(&mut counter, ROOM, Layout::Gray8);
    count::<Rgb565>(&mut counter, ROOM, Layout::Rgb565);
    count::<Rgb565Be>(&mut counter, ROOM, Layout::Rgb565);
    count::<Yuyv>(&mut counter, ROOM, Layout::Yuyv);
    count::<Uyvy>(&mut counter, ROOM, Layout::Yuyv);
    count::<Chroma420>(&mut counter, ROOM, Layout::Gray8);
    count::<Rgb8>(&mut counter, ROOM, Layout::Rgb8);
    count_tone::<Gray8>(&mut counter, ROOM, Layout::Gray8);
    count_tone::<Rgb565>(&mut counter, ROOM, Layout::Rgb565);
    count_tone::<Rgb565Be>(&mut counter, ROOM, Layout::Rgb565);
    count_tone::<Yuyv>(&mut counter, ROOM, Layout::Yuyv);
    count_tone::<Uyvy>(&mut counter, ROOM, Layout::Yuyv);
    count_tone::<Chroma420>(&mut counter, ROOM, Layout::Gray8);
    count_tone::<Rgb8>(&mut counter, ROOM, Layout::Rgb8);
    count_scales::<Gray8>(&mut counter, ROOM);
    count_scales::<Rgb565>(&mut counter, ROOM);
    count_scales::<Rgb565Be>(&mut counter, ROOM);
    count_scales::<Yuyv>(&mut counter, ROOM);
    count_scales::<Uyvy>(&mut counter, ROOM);
    count_scales::<Rgb8>(&mut counter, ROOM);
    count_lookup(&mut counter);
    count_targets(&mut counter);
    exit_success()
}

/// Scales over a picture, for each of its pixels.
fn count_scales<F: PixelFormat>(counter: &mut Counter, room: &mut [u8]) {
    let tables = defmt::unwrap!(Tables::parse(data::SCALED));
    let painter = Painter::<F>::new(defmt::unwrap!(tables.overlay()));
    let row_bytes = usize::from(tables.output_width_px()) * F::BYTES_PER_PIXEL;
    let picture = &mut room[..row_bytes * usize::from(tables.output_height_px())];
    let (instructions, result) = counter.instructions(|| draw(&painter, picture, row_bytes));
    defmt::unwrap!(result);
    log_per_pixel(format_args!("{} scales", F::NAME), &tables, instructions);
}

/// Queries of each kind, the mean over some places.
fn count_lookup(counter: &mut Counter) {
    let tables = defmt::unwrap!(Tables::parse(data::PICTURE));
    let lookup = Lookup::new(&tables);
    let around = || {
        (0i16..16).map(|i| Direction {
            yaw: BinaryAngle(9000 + 500 * i),
            pitch: BinaryAngle(500 * i - 4000),
        })
    };
    let pixels = || (0..16).map(|i| [(100 + 5 * i) << 8, (60 + 6 * i) << 8]);
    let mut log_mean = |what: &str, ask: &dyn Fn() -> usize| {
        let (instructions, answers) = counter.instructions(ask);
        defmt::assert!(answers == 16);
        log(&format_args!(
            "lookup {what} {} instructions/query",
            instructions / 16
        ));
    };
    log_mean("direction of output pixel", &|| {
        pixels()
            .filter_map(|p| lookup.direction_of_pixel(p))
            .count()
    });
    log_mean("output pixel of direction", &|| {
        around()
            .filter_map(|d| lookup.pixel_of_direction(d))
            .count()
    });
    log_mean("direction of eye pixel", &|| {
        let asked = pixels().map(|p| lookup.direction_of_eye_pixel(Eye::Left, p));
        asked.flatten().count()
    });
    log_mean("eye pixel of direction", &|| {
        let asked = around().map(|d| lookup.eye_pixel_of_direction(Eye::Left, d));
        asked.flatten().count()
    });
}

/// Boxes of a moment, taken and merged.
fn count_targets(counter: &mut Counter) {
    let tables = defmt::unwrap!(Tables::parse(data::PICTURE));
    let mut targets = Targets::<BOXES>::new(&tables);
    let (instructions, result) =
        counter.instructions(|| boxes::add(&mut targets, boxes::boxes(&tables)));
    defmt::unwrap!(result);
    log(&format_args!(
        "targets {BOXES} boxes taken {instructions} instructions/frame"
    ));
    let (instructions, merged) = counter.instructions(|| targets.merged(TOLERANCE));
    defmt::assert!(!merged.is_empty());
    log(&format_args!(
        "targets {BOXES} boxes merged {instructions} instructions/frame"
    ));
}

/// Tone with a curve for every channel: what a picture of one eye takes more than without. Then
/// what a frame takes for metering both eyes, and for new curves.
fn count_tone<F: PixelFormat>(counter: &mut Counter, room: &mut [u8], layout: Layout) {
    let tables = defmt::unwrap!(Tables::parse(data::ONE_EYE));
    let [left, right] = pair::<F>(&tables, data::frames(layout)).expect("wrong frames");
    let plain = defmt::unwrap!(Stitcher::<F>::new(&tables, Sampler::Nearest));
    let mut tone = Tone::new(&tables, Gains::ONE);
    let [without, with] = [plain, plain.with_tone(&tone)].map(|stitcher| {
        let stride = stitcher.row_bytes();
        let (instructions, result) =
            counter.instructions(|| stitcher.frame(&left, &right, room, stride));
        defmt::unwrap!(result);
        instructions
    });
    log_per_pixel(
        format_args!("{} tone", F::NAME),
        &tables,
        with.saturating_sub(without),
    );

    let tables = defmt::unwrap!(Tables::parse(data::TONED));
    let (mut meter, mut exposure) = (Meter::new(), Exposure::new(Exposure::USUAL_RATE));
    // A plane of chroma has nothing to meter.
    if F::CHANNELS.contains(&F::METERED) {
        let (instructions, result) = counter.instructions(|| {
            meter.read(&tables, Eye::Left, &left)?;
            meter.read(&tables, Eye::Right, &right)?;
            Ok::<_, StitchError>(exposure.update(&meter))
        });
        defmt::assert!(defmt::unwrap!(result));
        let pairs = tables.meter_pairs().len();
        log(&format_args!(
            "{} metering {pairs} pairs {instructions} instructions/frame",
            F::NAME
        ));
    }
    let (instructions, ()) = counter.instructions(|| tone.set(&tables, exposure.gains()));
    log(&format_args!(
        "{} curves {instructions} instructions/frame",
        F::NAME
    ));
}

fn count<F: PixelFormat>(counter: &mut Counter, room: &mut [u8], layout: Layout) {
    for (sampler_name, sampler) in SAMPLERS {
        for (kind, table) in KINDS {
            let tables = defmt::unwrap!(Tables::parse(table));
            let [left, right] = pair::<F>(&tables, data::frames(layout)).expect("wrong frames");
            let stitcher = defmt::unwrap!(Stitcher::<F>::new(&tables, sampler));
            let stride = stitcher.row_bytes();
            let (instructions, result) =
                counter.instructions(|| stitcher.frame(&left, &right, room, stride));
            defmt::unwrap!(result);
            log_per_pixel(
                &format_args!("{} {sampler_name} {kind}", F::NAME),
                &tables,
                instructions,
            );
        }
    }
}

fn log_per_pixel(what: impl core::fmt::Display, tables: &Tables, instructions: u64) {
    let width = u64::from(tables.output_width_px());
    let pixels = width * u64::from(tables.output_height_px());
    let hundredths = (100 * instructions + pixels / 2) / pixels;
    let (whole, rest) = (hundredths / 100, hundredths % 100);
    log(&format_args!("{what} {whole}.{rest:02} instructions/px"));
}
