//! Links only if no panic path is left in any entry point of the core, in any format.
#![no_std]
#![no_main]

use tectum_board::{entry, exit_success};
use tectum_core::{Chroma420, Gray8, Rgb8, Rgb565, Rgb565Be, Uyvy, Yuyv};
use tectum_proofs::{display, exposure, lookup, nv12, overlay, stitch, targets};

#[entry]
fn main() -> ! {
    static mut ROOM: [u8; 64] = [0; 64];
    stitch::<Gray8>(ROOM);
    stitch::<Rgb565>(ROOM);
    stitch::<Rgb565Be>(ROOM);
    stitch::<Yuyv>(ROOM);
    stitch::<Uyvy>(ROOM);
    stitch::<Chroma420>(ROOM);
    stitch::<Rgb8>(ROOM);
    exposure::<Gray8>();
    exposure::<Rgb565>();
    exposure::<Rgb565Be>();
    exposure::<Yuyv>();
    exposure::<Uyvy>();
    exposure::<Chroma420>();
    exposure::<Rgb8>();
    overlay::<Gray8>(ROOM);
    overlay::<Rgb565>(ROOM);
    overlay::<Rgb565Be>(ROOM);
    overlay::<Yuyv>(ROOM);
    overlay::<Uyvy>(ROOM);
    overlay::<Chroma420>(ROOM);
    overlay::<Rgb8>(ROOM);
    nv12(ROOM);
    display::<false>(ROOM);
    display::<true>(ROOM);
    lookup();
    targets();
    #[cfg(feature = "deliberate-panic")]
    {
        ROOM[core::hint::black_box(64)] = 0;
    }
    exit_success()
}
