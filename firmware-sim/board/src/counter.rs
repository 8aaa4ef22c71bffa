//! Instructions executed, from SysTick under QEMU's `-icount shift=0`.
//!
//! There every instruction takes 1 ns of virtual time, so a tick of the 25 MHz clock of the MPS2
//! boards is 40 instructions (31.25 with the 32 MHz of AN547), repeatably. These are instructions,
//! not cycles: caches, wait states and dual issue are not modelled.

use core::arch::asm;

use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};

/// SysTick counts down through 24 bits.
const TICKS: u32 = 1 << 24;
/// The reference loop has two instructions a turn.
const REFERENCE_TURNS: u32 = 2_000_000;

/// Counts the instructions of a closure.
pub struct Counter {
    syst: SYST,
    reference_ticks: u32,
}

impl Counter {
    /// Starts SysTick and measures the length of a tick on a loop of known length. Panics the
    /// second time: there is one SysTick.
    pub fn take() -> Self {
        let mut syst = Peripherals::take().expect("the counter is taken once").SYST;
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(TICKS - 1);
        syst.clear_current();
        syst.enable_counter();
        let mut counter = Self {
            syst,
            reference_ticks: 1,
        };
        counter.reference_ticks = counter.ticks(reference_loop).0;
        counter
    }

    /// Runs `work` and returns the instructions it took, to within one tick, and its result.
    ///
    /// One measurement may last 2^24 ticks, 520 million instructions at the least; a longer one
    /// ends the program with a panic, for the figure would be wrong.
    pub fn instructions<R>(&mut self, work: impl FnOnce() -> R) -> (u64, R) {
        let (ticks, result) = self.ticks(work);
        let reference = 2 * u64::from(REFERENCE_TURNS);
        (
            u64::from(ticks) * reference / u64::from(self.reference_ticks),
            result,
        )
    }

    #[inline(never)]
    fn ticks<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R) {
        self.syst.clear_current();
        // The first tick reloads the counter.
        while SYST::get_current() == 0 {}
        self.syst.has_wrapped();
        let before = SYST::get_current();
        let result = work();
        let after = SYST::get_current();
        assert!(
            !self.syst.has_wrapped(),
            "the measured work outlasts the 24 bits of SysTick"
        );
        (before - after, result)
    }
}

/// `REFERENCE_TURNS` turns of two instructions.
#[allow(unsafe_code)]
fn reference_loop() {
    // SAFETY: touches one scratch register and the flags, both declared.
    unsafe {
        asm!("2:", "subs {n}, #1", "bne 2b", n = inout(reg) REFERENCE_TURNS => _, options(nomem, nostack));
    }
}
