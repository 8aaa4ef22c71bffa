//! What the machine said.

use anyhow::{Context, bail};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;

/// vivid's first test pattern, 75 % colour bars, from left to right, sRGB.
const BARS: [[u8; 3]; 8] = [
    [191, 191, 191],
    [191, 191, 0],
    [0, 191, 191],
    [0, 191, 0],
    [191, 0, 191],
    [191, 0, 0],
    [0, 0, 191],
    [0, 0, 0],
];
/// Checks that the script makes; fewer means that it broke off.
const MIN_CHECKS: usize = 72;

/// Fails with everything that failed.
pub fn judge(said: &str) -> anyhow::Result<()> {
    let mut failures = Vec::new();
    let mut passed = 0;
    let mut lines = said.lines().peekable();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("ok ") {
            println!("  ok {name}");
            passed += 1;
        } else if line.starts_with("FAIL ") {
            let mut failure = line.to_owned();
            while let Some(detail) = lines.next_if(|line| line.starts_with("  | ")) {
                failure = format!("{failure}\n{detail}");
            }
            failures.push(failure);
        } else if let Some(rest) = line.strip_prefix("PNG ") {
            let (format, png) = rest.split_once(' ').unwrap_or((rest, ""));
            match pattern(format, png) {
                Ok(()) => {
                    println!("  ok test pattern in {format}");
                    passed += 1;
                }
                Err(error) => failures.push(format!("FAIL test pattern in {format}: {error:#}")),
            }
        }
    }
    if !said.lines().any(|line| line == "done") {
        failures.push(format!("the machine broke off; it said:\n{said}"));
    }
    if !failures.is_empty() {
        bail!("{}", failures.join("\n"));
    }
    if passed < MIN_CHECKS {
        bail!("only {passed} of {MIN_CHECKS} checks were made; the machine said:\n{said}");
    }
    Ok(())
}

/// Compares the middle of each bar with what the pattern is made of. Behind the format may stand what
/// gave it: `/left` and `/right` are the halves of a picture.
fn pattern(format: &str, png: &str) -> anyhow::Result<()> {
    let (format, from) = format.split_once('/').unwrap_or((format, ""));
    let (bars, size_px) = match from {
        "left" => (&BARS[..4], (320, 360)),
        "right" => (&BARS[4..], (320, 360)),
        _ => (&BARS[..], (320, 180)),
    };
    let bytes = STANDARD.decode(png.trim()).context("no base64")?;
    let picture: RgbImage = image::load_from_memory(&bytes)?.into_rgb8();
    let (width, height) = picture.dimensions();
    if (width, height) != size_px {
        bail!("it is {width}x{height} px");
    }
    for (i, bar) in bars.iter().enumerate() {
        let x = width * (2 * i as u32 + 1) / (2 * bars.len() as u32);
        let seen = picture.get_pixel(x, height / 2).0;
        let (wanted, tolerance) = expected(format, *bar);
        let off = seen.iter().zip(wanted).map(|(s, w)| s.abs_diff(w)).max();
        if off.is_some_and(|off| off > tolerance) {
            bail!("bar {i} is {seen:?} where {wanted:?} was due, give or take {tolerance}");
        }
    }
    Ok(())
}

/// A bar as the picture shows it, and how far off it may be.
fn expected(format: &str, [r, g, b]: [u8; 3]) -> ([u8; 3], u8) {
    // The driver makes grey by the weights of BT.709, rounded down.
    let luma = (2126 * u32::from(r) + 7152 * u32::from(g) + 722 * u32::from(b)) / 10_000;
    match format {
        "RGB3" => ([r, g, b], 0),
        // Steps of 5 bits are 8.
        "RGB565" => ([r, g, b], 8),
        "GREY" => ([luma as u8; 3], 2),
        // Half a step of luma and of chroma times up to 1.772, each stretched by 255/219, on both
        // sides.
        _ => ([r, g, b], 5),
    }
}
