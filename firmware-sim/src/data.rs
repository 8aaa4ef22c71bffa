//! Tables and frames, as the build script wrote them.

use tectum_fixture::frames::Layout;

include!(concat!(env!("OUT_DIR"), "/sizes.rs"));

/// The table of the real picture.
pub static PICTURE: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/picture.tct"));
/// The same with tone curves and metering pairs.
pub static TONED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/toned.tct"));
/// The table of the real picture with scales.
pub static SCALED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/scaled.tct"));
/// All pixels from the left eye.
pub static ONE_EYE: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/one_eye.tct"));
/// All pixels blended from both eyes.
pub static BLEND: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/blend.tct"));
/// Random tables, each behind its CRC-32 of all pictures on the host and its length.
pub static RANDOM: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/random.bin"));
/// No pixel from any eye.
pub static VOID: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/void.tct"));

/// The left and the right frame in the memory that the board keeps for frames.
pub fn frames(layout: Layout) -> [&'static [u8]; 2] {
    match layout {
        Layout::Gray8 => pair!("gray8"),
        Layout::Rgb565 => pair!("rgb565"),
        Layout::Yuyv => pair!("yuyv"),
        Layout::Rgb8 => pair!("rgb8"),
    }
}

macro_rules! pair {
    ($layout:literal) => {
        [
            frame!(concat!($layout, "_left")),
            frame!(concat!($layout, "_right")),
        ]
    };
}
use pair;

macro_rules! frame {
    ($name:expr) => {{
        const BYTES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/", $name, ".raw"));
        // SAFETY: the linker scripts place this section in memory of its own.
        #[allow(unsafe_code)]
        #[unsafe(link_section = ".frames")]
        static FRAME: [u8; BYTES.len()] =
            *include_bytes!(concat!(env!("OUT_DIR"), "/", $name, ".raw"));
        &FRAME
    }};
}
use frame;
