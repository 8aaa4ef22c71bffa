//! Calls of the core for programs that are linked and measured, never run.
//!
//! Every input passes a `black_box`, so the compiler knows neither bytes nor lengths and has to keep
//! each check it cannot prove away. The panic handler calls a symbol that nobody defines: a program
//! with one panic path left does not link.
#![no_std]

use core::hint::black_box;
use core::panic::PanicInfo;

use tectum_core::{
    AngularSize, BinaryAngle, Chroma420, Direction, Exposure, Eye, Frame, Gains, Gray8, Lookup,
    Meter, Nv12, Packed565, Painter, PixelBox, PixelFormat, Sampler, Stitcher, Tables, Targets,
    Tone, View, YuvRange,
};

#[panic_handler]
#[allow(unsafe_code)]
fn panic(_: &PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_path_is_left() -> !;
    }
    // SAFETY: never reached, for a program with this call in it does not link.
    unsafe { a_panic_path_is_left() }
}

/// Some bytes, of which the compiler knows nothing.
fn bytes() -> &'static [u8] {
    black_box(&[])
}

/// What a program holds that does not use the core.
pub fn nothing() {
    black_box(bytes());
}

/// Checks a table.
pub fn parse() {
    let _ = black_box(Tables::parse(bytes()));
}

/// Stitches in one format, in every way to run, after checking the table.
pub fn stitch<F: PixelFormat>(out: &mut [u8]) {
    let _ = black_box(try_stitch::<F>(black_box(out)));
}

fn try_stitch<F: PixelFormat>(out: &mut [u8]) -> Option<()> {
    let tables = Tables::parse(bytes()).ok()?;
    let frame = || Frame::<F>::new(bytes(), black_box(8), black_box(8), black_box(8)).ok();
    let (left, right) = (frame()?, frame()?);
    let sampler = if black_box(true) {
        Sampler::Nearest
    } else {
        Sampler::Bilinear
    };
    let stitcher = Stitcher::new(&tables, sampler).ok()?;
    // Curves from anywhere: how they come about is counted in `exposure`.
    let stitcher = match black_box(None::<&Tone<F>>) {
        Some(tone) => stitcher.with_tone(tone),
        None => stitcher,
    };
    let row = black_box(0);
    stitcher.row(&left, &right, row, out).ok()?;
    stitcher.frame(&left, &right, out, black_box(8)).ok()?;
    stitcher.left_row(&left, row, out).ok()?;
    stitcher.right_row(&right, row, out).ok()
}

/// Stitches both planes of NV12, in every way to run.
pub fn nv12(out: &mut [u8]) {
    let _ = black_box(Nv12::new(bytes(), black_box(8), black_box(8), black_box(8)));
    stitch::<Gray8>(out);
    stitch::<Chroma420>(out);
}

/// Meters, and sets curves.
pub fn exposure<F: PixelFormat>() {
    let _ = black_box(try_exposure::<F>());
}

fn try_exposure<F: PixelFormat>() -> Option<()> {
    let tables = Tables::parse(bytes()).ok()?;
    let frame = Frame::<F>::new(bytes(), black_box(8), black_box(8), black_box(8)).ok()?;
    let (mut meter, mut exposure) = (Meter::new(), Exposure::new(black_box(4)));
    meter.read(&tables, Eye::Left, &frame).ok()?;
    meter.read(&tables, Eye::Right, &frame).ok()?;
    exposure.update(&meter);
    let mut tone = Tone::<F>::new(&tables, Gains::ONE);
    tone.set(&tables, exposure.gains());
    black_box(tone);
    Some(())
}

/// Asks for directions and pixels.
pub fn lookup() {
    let Ok(tables) = Tables::parse(bytes()) else {
        return;
    };
    let lookup = Lookup::new(&tables);
    let pixel_q8 = black_box([0, 0]);
    let _ = black_box(lookup.direction_of_pixel(pixel_q8));
    let eye = if black_box(true) {
        Eye::Left
    } else {
        Eye::Right
    };
    let _ = black_box(lookup.direction_of_eye_pixel(eye, pixel_q8));
    let direction = Direction {
        yaw: BinaryAngle(black_box(0)),
        pitch: BinaryAngle(black_box(0)),
    };
    let _ = black_box(lookup.pixel_of_direction(direction));
    let _ = black_box(lookup.eye_pixel_of_direction(eye, direction));
}

/// Draws scales.
pub fn overlay<F: PixelFormat>(out: &mut [u8]) {
    let Ok(tables) = Tables::parse(bytes()) else {
        return;
    };
    let painter = tables.overlay().map(Painter::<F>::new);
    let _ = black_box(painter.map(|painter| painter.row(black_box(0), black_box(out))));
}

/// Turns rows into what displays take.
pub fn display<const BIG_ENDIAN: bool>(row: &mut [u8]) {
    for range in [YuvRange::Full, YuvRange::Limited] {
        let range = black_box(range);
        let _ = black_box(Packed565::<BIG_ENDIAN>::from_yuyv_in_place(
            black_box(row),
            range,
        ));
        let _ = black_box(Packed565::<BIG_ENDIAN>::from_uyvy_in_place(
            black_box(row),
            range,
        ));
    }
}

/// Makes targets of boxes.
pub fn targets() {
    let Ok(tables) = Tables::parse(bytes()) else {
        return;
    };
    let mut targets = Targets::<16>::new(&tables);
    let pixels = PixelBox {
        x: 1,
        y: 2,
        width: 3,
        height: 4,
    };
    for _ in 0..black_box(3) {
        let view = if black_box(true) {
            View::Eye(Eye::Left)
        } else {
            View::Stitched
        };
        let _ = black_box(targets.add(view, black_box(pixels)));
    }
    let tolerance = Targets::<16>::parallax(&tables, black_box(0.5));
    let _ = black_box(targets.merged(tolerance.max(AngularSize(black_box(9)))));
    targets.clear();
}
