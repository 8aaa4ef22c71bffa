//! Keeps the optimiser from rearranging sums on Arm.
#![allow(unsafe_code)]

/// The same value, which the optimiser cannot see through on Arm. No instruction.
///
/// Sums of small integers may be formed in any order, and LLVM likes orders that need more
/// registers than a Cortex-M has: it unrolls forward differences into sums of multiples, and adds
/// a rounding constant last instead of letting a multiply-add start from it. On the emulated M7
/// this saves 5 instructions of 49 a luma pixel. Elsewhere it does nothing.
#[inline(always)]
pub fn in_order(value: i32) -> i32 {
    #[cfg(target_arch = "arm")]
    {
        let mut value = value;
        // SAFETY: the assembly is a comment. It reads and writes nothing but the register that
        // holds `value`, which it leaves as it is; the firmware's hashes would show a change.
        unsafe {
            core::arch::asm!(
                "/* {0} */",
                inout(reg) value,
                options(pure, nomem, nostack, preserves_flags)
            );
        }
        value
    }
    #[cfg(not(target_arch = "arm"))]
    value
}
