//! What the kernels have in common, as text for the assembler.

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

/// r8 is what `smlad` adds where 2^15 was taken off each half: 2^23, which is 2^15 times the weights' sum of
/// 256, and 2^15 to round.
macro_rules! rounding {
    () => {
        "mov r8, #0x00800000
        orr r8, r8, #0x8000"
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

/// Both rows of the 2x2 box of a pixel of two bytes, a row in a word each: r11, and r12 below it.
macro_rules! box_of_halfwords {
    () => {
        "
        asr lr, r0, #24
        add r12, r6, lr, lsl #1
        asr lr, r3, #24
        mla r12, lr, r7, r12
        ldr r11, [r12]
        ldr r12, [r12, r7]
        "
    };
}
