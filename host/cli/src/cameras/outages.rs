//! Says at once when a camera goes away, why, and when it is back.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use tectum_capture::Health;

use crate::progress::Progress;

/// From one look at the cameras to the next.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// Looks at the cameras until dropped.
pub struct Outages {
    _ends: Sender<()>,
}

impl Outages {
    /// Begins to look; `eyes` are names and counters.
    pub fn tell(eyes: [Option<(String, Arc<Health>)>; 2], progress: &Progress) -> Self {
        let (ends, ended): (_, Receiver<()>) = channel();
        let note = progress.noter();
        std::thread::spawn(move || {
            let mut were_there = [true; 2];
            while ended.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
                for (eye, was_there) in eyes.iter().zip(&mut were_there) {
                    let Some((name, health)) = eye else {
                        continue;
                    };
                    let is_there = health.counts().connected;
                    if *was_there && !is_there {
                        let why = health.trouble().unwrap_or_else(|| name.clone());
                        note(&format!("waiting for a camera: {why}"));
                    } else if is_there && !*was_there {
                        note(&format!("{name}: back"));
                    }
                    *was_there = is_there;
                }
            }
        });
        Self { _ends: ends }
    }
}
