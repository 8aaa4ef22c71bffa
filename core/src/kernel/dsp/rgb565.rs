//! Five, six and five bits a pixel, in both orders of bytes.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::super::Position;
use super::super::cell::{Cell, CellKernel};

/// The kernel of RGB565.
#[inline(always)]
pub(crate) fn rgb565<P: Position, const BIG_ENDIAN: bool>() -> CellKernel {
    match (P::INTERPOLATES, BIG_ENDIAN) {
        (true, false) => rgb565_bilinear,
        (true, true) => rgb565be_bilinear,
        (false, _) => rgb565_nearest,
    }
}

/// One channel of two rows of two pixels, r11 and r12: masked, mixed down by r4, across by r5, into `$to`.
/// Fewer than 8 bits, so halves are positive to `smlad` and r8 is the rounding alone.
macro_rules! channel_565 {
    ($to:literal, $shift:literal, $mask:literal) => {
        concat!(
            "
            lsr r1, r11, #",
            $shift,
            "
            lsr r2, r12, #",
            $shift,
            "
            and r1, r1, #",
            $mask,
            "
            and r2, r2, #",
            $mask,
            "
            sub r2, r2, r1
            lsl r1, r1, #8
            mla r1, r2, r4, r1
            smlad ",
            $to,
            ", r1, r5, r8
            lsr ",
            $to,
            ", ",
            $to,
            ", #16
            "
        )
    };
}

macro_rules! rgb565_bilinear {
    ($name:ident, $loaded:literal, $stored:literal) => {
        /// Both pixels of a row are in one word.
        #[unsafe(naked)]
        unsafe extern "C" fn $name(cell: &Cell) {
            naked_asm!(
                extension!(),
                enter_with_stack!(),
                "mov r8, #0x8000",
                pixels_with_stack!(concat!(
                    box_of_halfwords!(),
                    $loaded,
                    "
                        ubfx r4, r3, #16, #8
                        ubfx r5, r0, #16, #8
                        rsb r5, r5, r5, lsl #16
                        add r5, r5, #256
                        and r1, r11, #0x001f001f
                        and r2, r12, #0x001f001f
                        sub r2, r2, r1
                        lsl r1, r1, #8
                        mla r1, r2, r4, r1
                        smlad lr, r1, r5, r8
                        lsr lr, lr, #16
                        ",
                    channel_565!("r1", "5", "0x003f003f"),
                    "orr lr, lr, r1, lsl #5",
                    channel_565!("r1", "11", "0x001f001f"),
                    "orr lr, lr, r1, lsl #11
                        ",
                    $stored,
                    "
                        strh lr, [r9], #2
                        "
                )),
                leave_stack!()
            )
        }
    };
}
rgb565_bilinear!(rgb565_bilinear, "", "");
rgb565_bilinear!(
    rgb565be_bilinear,
    "rev16 r11, r11\nrev16 r12, r12",
    "rev16 lr, lr"
);

/// Words as they are, whatever the order of their bytes.
#[unsafe(naked)]
unsafe extern "C" fn rgb565_nearest(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter!(),
        pixels!(
            "3",
            "
            asr lr, r3, #24
            mla lr, lr, r7, r6
            asr r12, r0, #24
            ldrh lr, [lr, r12, lsl #1]
            strh lr, [r9], #2
            "
        ),
        leave!()
    )
}
