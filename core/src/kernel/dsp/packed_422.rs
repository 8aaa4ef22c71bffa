//! 4:2:2, two pixels in four bytes, luma first or chroma.
#![allow(unsafe_code)]

use core::arch::naked_asm;

use super::super::Position;
use super::super::cell::{Cell, CellKernel};

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
            box_of_halfwords!(),
            "
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
                rounding!(),
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
