//! The next cell of a run.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::super::cell::Run;

/// Coefficients and differences of one axis. `$p3` is the new row value, which goes into the ring at `$ring`;
/// offset and differences go to `$to`, the third to `$third`. Shifts are in r11, r12 and lr; leaves the row
/// value of the cell's start in r5.
macro_rules! axis {
    ($p3:literal, $ring:literal, $last:literal, $to:literal, $second:literal, $third:literal) => {
        concat!(
            "
            ldrd r4, r5, [r0, #",
            $ring,
            "]
            ldr r6, [r0, #",
            $last,
            "]
            strd r5, r6, [r0, #",
            $ring,
            "]
            str ",
            $p3,
            ", [r0, #",
            $last,
            "]
            sub r7, r6, r4
            sub r8, r5, r6
            add r9, r8, r8, lsl #1
            add r9, r9, ",
            $p3,
            "
            sub r9, r9, r4
            add r10, r7, r9
            add r10, r10, r8, lsl #1
            lsl r7, r7, r11
            lsl r10, r10, r12
            lsl r9, r9, lr
            sub r7, r7, r10
            add r7, r7, r9
            add r9, r9, r9, lsl #1
            sub r8, r9, r10
            lsl r8, r8, #1
            lsl r9, r9, #1
            ldr r6, [r0, #124]
            uxtb r4, r5
            add r6, r6, r4, lsl #16
            strd r6, r7, [r0, #",
            $to,
            "]
            str r8, [r0, #",
            $second,
            "]
            str r9, [r0, #",
            $third,
            "]
            "
        )
    };
}

/// Sets up the next cell of a run from its new column of vertices: row values as `RowWeights::apply` of
/// `tectum-tables` has them, both axes as `Axis::new`. Differences of neighbours fit 16 bits, as a mesh's
/// check grants. r10 holds minus the second coefficient.
///
/// # Safety
/// Reads and writes `run` alone; its pointers are computed with, not followed.
#[unsafe(naked)]
pub(crate) unsafe extern "C" fn set_up(run: &mut Run, a: u32, b: u32, c: u32, d: u32) {
    naked_asm!(
        extension!(),
        "push {{r4-r11, lr}}
        ldr r4, [sp, #36]
        ssub16 r11, r2, r1
        ssub16 r12, r3, r2
        ssub16 lr, r4, r3
        add r10, r0, #56
        ldm r10, {{r5-r10}}
        sxth r1, r11
        mla r1, r1, r5, r8
        sxth r3, r12
        mla r1, r3, r6, r1
        sxth r3, lr
        mla r1, r3, r7, r1
        asr r1, r1, r9
        sxth r3, r2
        lsl r3, r3, r10
        add r1, r1, r3
        asr r11, r11, #16
        mla r11, r11, r5, r8
        asr r12, r12, #16
        mla r11, r12, r6, r11
        asr lr, lr, #16
        mla r11, lr, r7, r11
        asr r11, r11, r9
        asr r2, r2, #16
        lsl r2, r2, r10
        add r2, r2, r11
        ldrd r11, r12, [r0, #80]
        ldr lr, [r0, #88]",
        axis!("r1", "100", "108", "0", "8", "36"),
        "asr r1, r5, #8
        str r1, [r0, #128]",
        axis!("r2", "112", "120", "12", "20", "40"),
        "asr r5, r5, #8
        ldr r4, [r0, #28]
        ldrd r6, r7, [r0, #92]
        mla r6, r5, r4, r6
        mla r6, r1, r7, r6
        str r6, [r0, #24]
        pop {{r4-r11, pc}}"
    )
}
