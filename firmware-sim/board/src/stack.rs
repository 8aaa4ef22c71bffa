//! Stack high-water mark by painting.

use core::{arch::asm, ptr};

/// Unlikely as data: a word of this value counts as untouched.
const PAINT: u32 = 0xCAFE_57AC;
/// Depth watched below the caller. The core promises far less.
const WATCHED_BYTES: usize = 32 * 1024;
/// Left unpainted under the stack pointer, for this function's own use.
const MARGIN_BYTES: usize = 64;

/// Runs `work` and returns the bytes of stack it used at most, and its result. What is put on the
/// stack between this call and the work itself counts too, and a part of the last word may be
/// missing, so the figure is good to some tens of bytes.
///
/// Panics when the work outruns the 32 KB watched.
#[inline(never)]
#[allow(unsafe_code)]
pub fn high_water_bytes<R>(work: impl FnOnce() -> R) -> (usize, R) {
    let top = stack_pointer() - MARGIN_BYTES;
    let bottom = top - WATCHED_BYTES;
    for address in (bottom..top).step_by(4) {
        // SAFETY: memory below the stack pointer and above `.bss` (the boards have megabytes, or on
        // the M55 over 100 KB, between them) belongs to the stack and nothing lives there now.
        unsafe { ptr::write_volatile(address as *mut u32, PAINT) };
    }
    let result = apart(work);
    let touched = (bottom..top)
        .step_by(4)
        // SAFETY: as above.
        .find(|&address| unsafe { ptr::read_volatile(address as *const u32) } != PAINT);
    assert!(
        touched != Some(bottom),
        "the stack outran the depth watched"
    );
    (
        touched.map_or(0, |address| top + MARGIN_BYTES - address),
        result,
    )
}

/// Runs `work` in a frame of its own: one that the caller shared would lie above what is watched.
#[inline(never)]
fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[allow(unsafe_code)]
fn stack_pointer() -> usize {
    let sp: usize;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) sp, options(nomem, nostack, preserves_flags)) };
    sp & !3
}
