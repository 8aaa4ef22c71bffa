//! Kernels for the DSP instructions of Armv7E-M (Cortex-M4, M7, and M55 and its kin): whole cells in
//! assembly, because a compiler that allocates registers spills in the middle of a pixel.
//!
//! Each gives the bytes of the portable loop of its format, which defines them; the firmware's tests
//! compare both. In all of them, while a pixel is made:
//!
//! | register | holds |
//! |---|---|
//! | r0 to r2 | offset in x, Q24, first and second difference |
//! | r3 to r5 | the same in y |
//! | r6, r7 | base, stride |
//! | r9 | next output byte |
//! | r10 | third difference in x |
//!
//! The kernels follow the procedure call standard, keep every register that it says to keep, call
//! nothing, and use up to 48 bytes of stack.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::Position;
use super::cell::{Cell, CellKernel};

/// The kernel of Gray8.
#[inline(always)]
pub(crate) fn gray8<P: Position>() -> CellKernel {
    if P::INTERPOLATES {
        gray8_bilinear
    } else {
        gray8_nearest
    }
}

/// Saves registers and loads a cell: `d3y` and `end` go to the stack, at sp and sp + 4.
macro_rules! enter {
    () => {
        "push {{r4-r11, lr}}
        ldr r9, [r0, #32]
        ldrd r10, r1, [r0, #36]
        ldr r2, [r0, #44]
        push {{r1, r2}}
        ldm r0, {{r0-r7}}"
    };
}

/// Restores what `enter` saved, and returns.
macro_rules! leave {
    () => {
        "add sp, sp, #8
        pop {{r4-r11, pc}}"
    };
}

/// Moves both axes on to the next pixel. Uses lr.
macro_rules! step {
    () => {
        "
        ldr lr, [sp]
        add r0, r0, r1
        add r1, r1, r2
        add r2, r2, r10
        add r3, r3, r4
        add r4, r4, r5
        add r5, r5, lr
        "
    };
}

/// Goes through the pixels of a cell: first as many as four leave over, one by one, then by fours.
/// `$log2` is that of four pixels' bytes, `$pixel` makes one and moves r9 on.
macro_rules! pixels {
    ($log2:literal, $pixel:expr) => {
        concat!(
            "
            ldr lr, [sp, #4]
            sub lr, lr, r9
            lsls lr, lr, #32 - ",
            $log2,
            "
            beq 3f
            2:",
            $pixel,
            step!(),
            "
            ldr lr, [sp, #4]
            sub lr, lr, r9
            lsls lr, lr, #32 - ",
            $log2,
            "
            bne 2b
            3:
            ldr lr, [sp, #4]
            cmp r9, lr
            beq 5f
            4:
            .rept 4",
            $pixel,
            step!(),
            "
            .endr
            ldr lr, [sp, #4]
            cmp r9, lr
            bne 4b
            5:
            "
        )
    };
}

/// Weights 256 - f and f of the fraction in bits 23..16 of an axis, as the lower and upper half of lr.
macro_rules! weights {
    ($axis:literal) => {
        concat!(
            "
            ubfx lr, ",
            $axis,
            ", #16, #8
            rsb lr, lr, lr, lsl #16
            add lr, lr, #256
            "
        )
    };
}

/// Both rows are mixed across at once, in the halves of one register: at most 255 * 256 each, so that
/// nothing carries. Halves are signed to `smlad`, so that 2^15 is taken off each before; r8, 2^23 + 2^15,
/// puts the sum of that back and rounds.
#[unsafe(naked)]
unsafe extern "C" fn gray8_bilinear(cell: &Cell) {
    naked_asm!(
        enter!(),
        "mov r8, #0x00800000
        orr r8, r8, #0x8000",
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
