//! Luma, a byte a pixel.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::super::Position;
use super::super::cell::{Cell, CellKernel};

/// The kernel of Gray8.
#[inline(always)]
pub(crate) fn gray8<P: Position>() -> CellKernel {
    if P::INTERPOLATES {
        gray8_bilinear
    } else {
        gray8_nearest
    }
}

/// Both rows are mixed across at once, in the halves of one register: at most 255 * 256 each, so that
/// nothing carries. Halves are signed to `smlad`, so that 2^15 is taken off each before; r8, 2^23 + 2^15,
/// puts the sum of that back and rounds.
#[unsafe(naked)]
unsafe extern "C" fn gray8_bilinear(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter!(),
        rounding!(),
        pixels!(
            "2",
            concat!(
                "
                add r12, r6, r0, asr #24
                asr lr, r3, #24
                mla r12, lr, r7, r12
                ldrh lr, [r12]
                ldrh r12, [r12, r7]
                pkhbt r12, lr, r12, lsl #16
                ubfx lr, r0, #16, #8
                uxtb16 r11, r12, ror #8
                uxtb16 r12, r12
                mul r11, r11, lr
                rsb lr, lr, #256
                mla r12, r12, lr, r11
                eor r12, r12, #0x80008000",
                weights!("r3"),
                "
                smlad r12, r12, lr, r8
                lsr r12, r12, #16
                strb r12, [r9], #1
                "
            )
        ),
        leave!()
    )
}

/// The pixel at a position that the axes have rounded already.
#[unsafe(naked)]
unsafe extern "C" fn gray8_nearest(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter!(),
        pixels!(
            "2",
            "
            asr lr, r3, #24
            mla lr, lr, r7, r6
            asr r12, r0, #24
            ldrb lr, [lr, r12]
            strb lr, [r9], #1
            "
        ),
        leave!()
    )
}
