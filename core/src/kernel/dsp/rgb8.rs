//! Three bytes a pixel.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::super::Position;
use super::super::cell::{Cell, CellKernel};

/// The kernel of RGB8.
#[inline(always)]
pub(crate) fn rgb8<P: Position>() -> CellKernel {
    if P::INTERPOLATES {
        rgb8_bilinear
    } else {
        rgb8_nearest
    }
}

/// Red and blue of a pixel lie two bytes apart and are mixed together, green of both rows.
#[unsafe(naked)]
unsafe extern "C" fn rgb8_bilinear(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter_with_stack!(),
        rounding!(),
        pixels_with_stack!(concat!(
            "
                asr lr, r0, #24
                add lr, lr, lr, lsl #1
                add r12, r6, lr
                asr lr, r3, #24
                mla r12, lr, r7, r12
                ubfx lr, r0, #16, #8
                ldr r1, [r12]
                ldr r2, [r12, #2]
                add r12, r12, r7
                uxtb16 r4, r1
                uxtb16 r5, r2, ror #8
                ",
            mix_halves!("r4", "r5"),
            "
                uxtb16 r1, r1, ror #8
                uxtb16 r2, r2
                ldr r5, [r12]
                ldr r12, [r12, #2]
                uxtb16 r11, r5, ror #8
                pkhbt r1, r1, r11, lsl #16
                uxtb16 r11, r12
                pkhtb r2, r11, r2, asr #16
                uxtb16 r5, r5
                uxtb16 r12, r12, ror #8
                ",
            mix_halves!("r5", "r12"),
            mix_halves!("r1", "r2"),
            weights!("r3"),
            "
                pkhbt r2, r4, r5, lsl #16
                pkhtb r4, r5, r4, asr #16
                ",
            mix_across!("r2"),
            mix_across!("r1"),
            mix_across!("r4"),
            "
                strb r1, [r9, #1]
                strb r4, [r9, #2]
                strb r2, [r9], #3
                "
        )),
        leave_stack!()
    )
}

#[unsafe(naked)]
unsafe extern "C" fn rgb8_nearest(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter!(),
        pixels!(
            "2",
            "
            asr lr, r3, #24
            mla lr, lr, r7, r6
            asr r12, r0, #24
            add r12, r12, r12, lsl #1
            add lr, lr, r12
            ldrh r11, [lr]
            ldrb r12, [lr, #2]
            strh r11, [r9]
            strb r12, [r9, #2]
            add r9, r9, #3
            "
        ),
        leave!()
    )
}
