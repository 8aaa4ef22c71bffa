//! Progress on stderr, drawn only on a terminal.

use std::borrow::Cow;
use std::io::{self, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that goes on by steps; it vanishes when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of `steps`.
    pub fn new(steps: u64) -> Self {
        let bar = ProgressBar::new(steps);
        bar.enable_steady_tick(Duration::from_millis(100));
        // The template is a constant; were it wrong, the plain bar would do.
        let style = ProgressStyle::with_template("{spinner} {bar:30} {msg} ({elapsed})");
        Self(match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }

    /// For work without an end: what is going on, and for how long.
    pub fn endless() -> Self {
        let bar = ProgressBar::new_spinner();
        bar.enable_steady_tick(Duration::from_millis(100));
        let style = ProgressStyle::with_template("{spinner} {msg} ({elapsed})");
        Self(match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }

    /// Says what is going on.
    pub fn say(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(what);
    }

    /// Prints a line that stays, above what is drawn.
    pub fn note(&self, line: &str) {
        // Nobody may be there to read it; the work goes on all the same.
        let whole = format!("{line}\n");
        self.0
            .suspend(|| drop(io::stderr().write_all(whole.as_bytes())));
    }

    /// Prints lines that stay, from another thread.
    pub fn noter(&self) -> impl Fn(&str) + Send + use<> {
        let bar = self.0.clone();
        move |line| bar.suspend(|| eprintln!("{line}"))
    }

    /// Makes the bar longer.
    pub fn more(&self, steps: usize) {
        self.0.inc_length(steps as u64);
    }

    /// Begins the next step.
    pub fn step(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(what);
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
