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
#[macro_use]
mod macros;
mod gray8;
mod packed_422;
mod rgb565;
mod rgb8;
mod set_up;

pub(crate) use gray8::gray8;
pub(crate) use packed_422::packed_422;
pub(crate) use rgb8::rgb8;
pub(crate) use rgb565::rgb565;
pub(crate) use set_up::set_up;
