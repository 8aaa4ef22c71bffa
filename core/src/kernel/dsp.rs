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
//! | r10 | third difference in x, or the end of the output |
//!
//! The kernels follow the procedure call standard, keep every register that it says to keep, call
//! nothing, and use up to 64 bytes of stack.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::Position;
use super::cell::{Cell, CellKernel, Run};

/// The kernel of Gray8.
#[inline(always)]
pub(crate) fn gray8<P: Position>() -> CellKernel {
    if P::INTERPOLATES {
        gray8_bilinear
    } else {
        gray8_nearest
    }
}

/// The kernel of RGB565.
#[inline(always)]
pub(crate) fn rgb565<P: Position, const BIG_ENDIAN: bool>() -> CellKernel {
    match (P::INTERPOLATES, BIG_ENDIAN) {
        (true, false) => rgb565_bilinear,
        (true, true) => rgb565be_bilinear,
        (false, _) => rgb565_nearest,
    }
}

/// The kernel of 4:2:2 with luma in byte `LUMA` of a pixel, for pairs.
#[inline(always)]
pub(crate) fn packed_422<P: Position, const LUMA: usize>() -> CellKernel {
    match (P::INTERPOLATES, LUMA) {
        (true, 0) => yuyv_bilinear,
        (true, _) => uyvy_bilinear,
        (false, 0) => yuyv_nearest,
        (false, _) => uyvy_nearest,
    }
}

/// The kernel of RGB8.
#[inline(always)]
pub(crate) fn rgb8<P: Position>() -> CellKernel {
    if P::INTERPOLATES {
        rgb8_bilinear
    } else {
        rgb8_nearest
    }
}

/// What the assembler needs to know before it takes DSP instructions.
#[cfg(not(arm_dsp = "optional"))]
macro_rules! extension {
    () => {
        ""
    };
}
#[cfg(arm_dsp = "optional")]
macro_rules! extension {
    () => {
        ".cpu cortex-m33"
    };
}

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
        extension!(),
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

/// Saves registers and loads a cell with all differences on the stack, x's first, so that a pixel has r1,
/// r2, r4 and r5 too. The last pair follows at sp + 24. r10 is `end`, r1 whether the first pixel is odd.
macro_rules! enter_with_stack {
    () => {
        "push {{r4-r11, lr}}
        ldrd r1, r2, [r0, #4]
        ldr r4, [r0, #36]
        ldrd r5, r11, [r0, #16]
        ldr r12, [r0, #40]
        ldr lr, [r0, #48]
        push {{r1, r2, r4, r5, r11, r12, lr}}
        ldrd r6, r7, [r0, #24]
        ldr r9, [r0, #32]
        ldr r10, [r0, #44]
        ldr r1, [r0, #52]
        ldr r3, [r0, #12]
        ldr r0, [r0]
        "
    };
}

/// Restores what `enter_with_stack` saved, and returns.
macro_rules! leave_stack {
    () => {
        "add sp, sp, #28
        pop {{r4-r11, pc}}"
    };
}

/// Moves both axes on to the next pixel, with their differences on the stack. Uses r1, r2, r4, r5, r11, r12.
macro_rules! step_on_stack {
    () => {
        "
        ldm sp, {{r1, r2, r4, r5, r11, r12}}
        add r0, r0, r1
        add r1, r1, r2
        add r2, r2, r4
        add r3, r3, r5
        add r5, r5, r11
        add r11, r11, r12
        stm sp, {{r1, r2, r4, r5, r11, r12}}
        "
    };
}

/// Goes through the pixels of a cell one by one, with differences on the stack.
macro_rules! pixels_with_stack {
    ($pixel:expr) => {
        concat!(
            "
            cmp r9, r10
            beq 5f
            2:",
            $pixel,
            step_on_stack!(),
            "
            cmp r9, r10
            bne 2b
            5:
            "
        )
    };
}

/// Mixes the halves of two registers by the Q8 fraction in lr: `$a` becomes `256 $a + ($b - $a) lr`.
/// Where halves of the difference are negative, the sum takes their borrow back. Uses `$b`.
macro_rules! mix_halves {
    ($a:literal, $b:literal) => {
        concat!(
            "
            sub ",
            $b,
            ", ",
            $b,
            ", ",
            $a,
            "
            lsl ",
            $a,
            ", ",
            $a,
            ", #8
            mla ",
            $a,
            ", ",
            $b,
            ", lr, ",
            $a,
            "
            "
        )
    };
}

/// Mixes the lower and upper half of a register by the weights in lr and rounds: a value up to 255.
macro_rules! mix_across {
    ($r:literal) => {
        concat!(
            "
            eor ",
            $r,
            ", ",
            $r,
            ", #0x80008000
            smlad ",
            $r,
            ", ",
            $r,
            ", lr, r8
            lsr ",
            $r,
            ", ",
            $r,
            ", #16
            "
        )
    };
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
                    "
                        asr lr, r0, #24
                        add r12, r6, lr, lsl #1
                        asr lr, r3, #24
                        mla r12, lr, r7, r12
                        ldr r11, [r12]
                        ldr r12, [r12, r7]
                        ",
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

/// Red and blue of a pixel lie two bytes apart and are mixed together, green of both rows.
#[unsafe(naked)]
unsafe extern "C" fn rgb8_bilinear(cell: &Cell) {
    naked_asm!(
        extension!(),
        enter_with_stack!(),
        "mov r8, #0x00800000
        orr r8, r8, #0x8000",
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

/// Goes through pixels that come in pairs of four bytes, the first of which may be a pair's odd one and
/// the last its even one. r9 is the pair.
macro_rules! pairs {
    ($even:expr, $odd:expr) => {
        concat!(
            "
            add r11, r9, r1, lsl #1
            cmp r11, r10
            beq 5f
            cmp r1, #0
            bne 3f
            2:",
            $even,
            step_on_stack!(),
            "
            sub lr, r10, #2
            cmp r9, lr
            beq 5f
            3:",
            $odd,
            step_on_stack!(),
            "
            add r9, r9, #4
            cmp r9, r10
            bne 2b
            5:
            "
        )
    };
}

/// Luma of a pixel: both neighbours of a row are in one word, `$ror` brings them to its halves.
macro_rules! luma_bilinear {
    ($ror:literal, $out:literal) => {
        concat!(
            "
            asr lr, r0, #24
            add r12, r6, lr, lsl #1
            asr lr, r3, #24
            mla r12, lr, r7, r12
            ldr r11, [r12]
            ldr r12, [r12, r7]
            uxtb16 r11, r11",
            $ror,
            "
            uxtb16 r12, r12",
            $ror,
            "
            ubfx lr, r3, #16, #8
            ",
            mix_halves!("r11", "r12"),
            weights!("r0"),
            mix_across!("r11"),
            "strb r11, [r9, #",
            $out,
            "]
            "
        )
    };
}

/// U and V of a pair, at half the position in x: a pair is two pixels, and base is that of a pair. The
/// last pair of a row stands for its right neighbour too.
macro_rules! chroma_bilinear {
    ($ror:literal, $u:literal, $v:literal) => {
        concat!(
            "
            asr lr, r0, #25
            add r12, r6, lr, lsl #2
            ldr r1, [sp, #24]
            sub r1, lr, r1
            lsr r1, r1, #29
            and r1, r1, #4
            asr lr, r3, #24
            mla r12, lr, r7, r12
            ldr r11, [r12]
            ldr r2, [r12, r1]
            add r12, r12, r7
            ldr r4, [r12]
            ldr r5, [r12, r1]
            ubfx lr, r0, #17, #8
            uxtb16 r11, r11",
            $ror,
            "
            uxtb16 r2, r2",
            $ror,
            "
            uxtb16 r4, r4",
            $ror,
            "
            uxtb16 r5, r5",
            $ror,
            "
            ",
            mix_halves!("r11", "r2"),
            mix_halves!("r4", "r5"),
            weights!("r3"),
            "
            pkhbt r1, r11, r4, lsl #16
            pkhtb r2, r4, r11, asr #16
            ",
            mix_across!("r1"),
            mix_across!("r2"),
            "
            strb r1, [r9, #",
            $u,
            "]
            strb r2, [r9, #",
            $v,
            "]
            "
        )
    };
}

/// Leaves the pixel's address in lr and its offset in x in r12.
macro_rules! luma_nearest {
    ($luma:literal, $out:literal) => {
        concat!(
            "
            asr lr, r3, #24
            mla lr, lr, r7, r6
            asr r12, r0, #24
            add lr, lr, r12, lsl #1
            ldrb r11, [lr, #",
            $luma,
            "]
            strb r11, [r9, #",
            $out,
            "]
            "
        )
    };
}

macro_rules! packed_422 {
    ($bilinear:ident, $nearest:ident, $luma_ror:literal, $chroma_ror:literal,
     $y0:literal, $u:literal, $y1:literal, $v:literal) => {
        #[unsafe(naked)]
        unsafe extern "C" fn $bilinear(cell: &Cell) {
            naked_asm!(
                extension!(),
                enter_with_stack!(),
                "mov r8, #0x00800000
                orr r8, r8, #0x8000",
                pairs!(
                    concat!(
                        luma_bilinear!($luma_ror, $y0),
                        chroma_bilinear!($chroma_ror, $u, $v)
                    ),
                    luma_bilinear!($luma_ror, $y1)
                ),
                leave_stack!()
            )
        }

        #[unsafe(naked)]
        unsafe extern "C" fn $nearest(cell: &Cell) {
            naked_asm!(
                extension!(),
                enter_with_stack!(),
                pairs!(
                    concat!(
                        luma_nearest!($y0, $y0),
                        "
                        and r12, r12, #1
                        sub lr, lr, r12, lsl #1
                        ldrb r11, [lr, #",
                        $u,
                        "]
                        ldrb r12, [lr, #",
                        $v,
                        "]
                        strb r11, [r9, #",
                        $u,
                        "]
                        strb r12, [r9, #",
                        $v,
                        "]
                        "
                    ),
                    luma_nearest!($y0, $y1)
                ),
                leave_stack!()
            )
        }
    };
}
packed_422!(
    yuyv_bilinear,
    yuyv_nearest,
    "",
    ", ror #8",
    "0",
    "1",
    "2",
    "3"
);
packed_422!(
    uyvy_bilinear,
    uyvy_nearest,
    ", ror #8",
    "",
    "1",
    "0",
    "3",
    "2"
);
