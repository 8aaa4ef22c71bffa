//! When to end, and where to show.

use std::net::SocketAddr;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use tectum_capture::Stop;

/// When to end; without either, at the end of the source or by Ctrl-C.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Limits {
    /// End after this many frames of each eye
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
    /// End after this long, s
    #[arg(long, value_name = "S", value_parser = crate::args::seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,
}

impl Limits {
    /// Whether either is given.
    pub fn is_given(&self) -> bool {
        self.frames.is_some() || self.seconds.is_some()
    }

    /// Goes on until it is time to end.
    pub fn flow(&self, frames: u64, start: Instant) -> ControlFlow<()> {
        let seconds = start.elapsed().as_secs_f64();
        let reached = self.frames.is_some_and(|most| frames >= most)
            || self.seconds.is_some_and(|most| seconds >= most);
        if reached {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// A preview beside the work.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ViewArgs {
    /// Show it in a browser too, at this address; anyone who can reach it can watch
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1,
        default_missing_value = "127.0.0.1:8088")]
    pub view: Option<SocketAddr>,
}

/// Stops at Ctrl-C, and by force at the second; and when the time is up.
pub fn stop_on_interrupt(limits: &Limits) -> anyhow::Result<Stop> {
    let stop = Stop::default();
    let handler = stop.clone();
    ctrlc::set_handler(move || {
        if handler.is_set() {
            std::process::exit(130);
        }
        handler.set();
    })?;
    if let Some(seconds) = limits.seconds {
        // A camera that is away gives no frame at which the time could be seen to be up.
        let stop = stop.clone();
        let wait = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX);
        std::thread::spawn(move || {
            std::thread::sleep(wait);
            stop.set();
        });
    }
    Ok(stop)
}
