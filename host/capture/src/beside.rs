//! Work for both eyes at once.

use std::panic::resume_unwind;
use std::thread;

/// Does the work for both eyes beside each other, the left one on a thread of its own, so that
/// neither waits for the other. A panic of either goes on.
pub fn beside_each_other<L: Send, R>(
    left: impl FnOnce() -> L + Send,
    right: impl FnOnce() -> R,
) -> (L, R) {
    thread::scope(|scope| {
        let left = scope.spawn(left);
        let right = right();
        (
            left.join().unwrap_or_else(|panic| resume_unwind(panic)),
            right,
        )
    })
}
