//! Links only if no panic path is left in any entry point of the core, in any format.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};
use tectum_core::{Gray8, Rgb8, Rgb565, Yuyv};
use tectum_proofs::{exposure, lookup, overlay, stitch, targets};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; 64] = [0; 64];
    stitch::<Gray8>(ROOM);
    stitch::<Rgb565>(ROOM);
    stitch::<Yuyv>(ROOM);
    stitch::<Rgb8>(ROOM);
    exposure::<Gray8>();
    exposure::<Rgb565>();
    exposure::<Yuyv>();
    exposure::<Rgb8>();
    overlay::<Gray8>(ROOM);
    overlay::<Rgb565>(ROOM);
    overlay::<Yuyv>(ROOM);
    overlay::<Rgb8>(ROOM);
    lookup();
    targets();
    #[cfg(feature = "deliberate-panic")]
    {
        ROOM[core::hint::black_box(64)] = 0;
    }
    exit_success()
}
