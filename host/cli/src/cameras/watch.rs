//! How it goes: rates, latency, losses; for the terminal, the preview and the report.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tectum_capture::preview::{Picture, Preview, Snapshot};
use tectum_capture::{
    CaptureError, Frame, FrameFormat, Health, Moment, Operator, PairStatistics, Recorded, Shot,
    monotonic_ns,
};

use super::Feed;
use super::feed::counts_json;
use super::outages::Outages;
use crate::progress::Progress;

/// From one line of figures to the next.
const SAY_EVERY: Duration = Duration::from_millis(500);
/// A clock that says a frame is older than this is another clock than ours.
const OLDEST_NS: i64 = 60_000_000_000;

/// The stitched picture of a moment.
type Stitched<'a> = (&'a [u8], FrameFormat);

/// Mean and greatest of some milliseconds.
#[derive(Debug, Clone, Copy, Default)]
struct Times {
    count: u64,
    sum_ms: f64,
    max_ms: f64,
}

impl Times {
    fn add(&mut self, ms: f64) {
        self.count += 1;
        self.sum_ms += ms;
        self.max_ms = self.max_ms.max(ms);
    }

    fn mean_ms(&self) -> f64 {
        self.sum_ms / self.count.max(1) as f64
    }

    fn text(&self) -> String {
        format!("{:.1} ms (max {:.1})", self.mean_ms(), self.max_ms)
    }

    fn json(&self) -> Value {
        json!({ "mean": self.mean_ms(), "max": self.max_ms })
    }
}

/// Counts and shows.
pub struct Watch {
    eyes: [Option<(String, Arc<Health>)>; 2],
    preview: Option<Preview>,
    operator: Option<Operator>,
    attitude: Value,
    session: Value,
    is_stitched: bool,
    /// The source has no more frames; the last ones stay.
    has_ended: bool,
    /// Each frame is shown: there may be no other.
    shows_all: bool,
    progress: Progress,
    _outages: Outages,
    start: Instant,
    shots: u64,
    work: Times,
    latency: Times,
    /// Shots that were left out, because a frame of them cannot be decoded.
    undecodable: u64,
    statistics: PairStatistics,
    /// Since the last line.
    lately: (Instant, u64, Times),
    rate_hz: f64,
    note: String,
}

impl Watch {
    /// Begins to count.
    pub fn new(feed: &Feed, preview: Option<Preview>) -> Self {
        let progress = Progress::endless();
        if let Some(preview) = &preview {
            progress.note(&preview.notice());
        }
        let watch = Self {
            eyes: feed.eyes(),
            preview,
            operator: None,
            attitude: Value::Null,
            session: Value::Null,
            is_stitched: false,
            has_ended: false,
            shows_all: !feed.is_live(),
            _outages: Outages::tell(feed.eyes(), &progress),
            progress,
            start: Instant::now(),
            shots: 0,
            undecodable: 0,
            work: Times::default(),
            latency: Times::default(),
            statistics: PairStatistics::default(),
            lately: (Instant::now(), 0, Times::default()),
            rate_hz: 0.0,
            note: String::new(),
        };
        watch.set_status();
        watch
    }

    /// With somebody who saves what clients of the preview ask for.
    pub fn with_operator(mut self, operator: Operator) -> Self {
        self.operator = Some(operator);
        self
    }

    /// The feed has been opened again.
    pub fn begin_again(&mut self, feed: &Feed) {
        self.eyes = feed.eyes();
        if let Some(preview) = &self.preview {
            preview.set_eyes(feed.eyes());
        }
        self._outages = Outages::tell(feed.eyes(), &self.progress);
    }

    /// How the body is turned at the shot to come, for the page.
    pub fn set_attitude(&mut self, attitude: Value) {
        self.attitude = attitude;
    }

    /// What the page draws and says of a calibration session.
    pub fn set_session(&mut self, session: Value) {
        self.session = session;
    }

    /// There will be no more frames; the last ones stay on the page.
    pub fn hold(&mut self) {
        self.has_ended = true;
        self.end_recording();
        let nothing = Moment {
            eyes: [None, None],
            stitched: None,
        };
        self.operate(&nothing);
        self.set_status();
    }

    /// The feed has ended: takes its last figures.
    ///
    /// # Errors
    /// If nothing came at all.
    pub fn end(&mut self, feed: &Feed) -> Result<(), CaptureError> {
        self.statistics = feed.statistics();
        self.end_recording();
        if self.shots > 0 {
            return Ok(());
        }
        let eyes = self.eyes.iter().flatten();
        Err(CaptureError::no_frames(
            eyes.map(|(name, health)| (&**name, &**health)),
        ))
    }

    /// So many shots were left out, because a frame of them cannot be decoded.
    pub fn leave_out(&mut self, shots: u64) {
        self.undecodable = shots;
    }

    /// Shots so far.
    pub fn shots(&self) -> u64 {
        self.shots
    }

    /// When it began.
    pub fn start(&self) -> Instant {
        self.start
    }

    /// A few words about what is going on, shown with the figures.
    pub fn say(&mut self, note: String) {
        self.note = note;
    }

    /// A shot was dealt with, which began at `begun`.
    pub fn shot(
        &mut self,
        shot: &Shot<'_>,
        stitched: Option<Stitched<'_>>,
        begun: Instant,
        statistics: &PairStatistics,
    ) {
        self.shots += 1;
        self.statistics = *statistics;
        self.lately.1 += 1;
        self.work.add(begun.elapsed().as_secs_f64() * 1e3);
        let taken = shot.iter().flatten().map(|frame| frame.time_ns).max();
        let age_ns = taken.map(|taken| monotonic_ns().wrapping_sub(taken));
        if let Some(ns) = age_ns.filter(|ns| (0..OLDEST_NS).contains(ns)) {
            let ms = ns as f64 / 1e6;
            self.latency.add(ms);
            self.lately.2.add(ms);
        }
        let stitched = stitched.and_then(|(data, format)| {
            let like = shot[0].or(shot[1])?;
            Some(Frame {
                data,
                format,
                ..like
            })
        });
        self.operate(&Moment {
            eyes: *shot,
            stitched,
        });
        if let Some(preview) = &self.preview {
            preview.frame_came();
            if self.shows_all || preview.is_due() {
                let [left, right] = shot.map(|frame| frame.as_ref().map(Picture::of));
                preview.publish(Snapshot {
                    number: self.shots,
                    stitched: stitched.as_ref().map(Picture::of),
                    left,
                    right,
                });
            }
        }
        self.is_stitched = stitched.is_some();
        if self.lately.0.elapsed() >= SAY_EVERY {
            self.rate_hz = self.lately.1 as f64 / self.lately.0.elapsed().as_secs_f64();
            self.progress.say(self.line());
            self.set_status();
            self.lately = (Instant::now(), 0, Times::default());
        }
    }

    /// What is being recorded for a client becomes whole on the disk.
    pub fn end_recording(&mut self) {
        if let Some(operator) = &mut self.operator {
            operator.end();
        }
    }

    fn recorded(&self) -> &[Recorded] {
        self.operator.as_ref().map_or(&[], Operator::recorded)
    }

    /// Records, and does what clients ask for.
    fn operate(&mut self, moment: &Moment<'_>) {
        let Some(operator) = &mut self.operator else {
            return;
        };
        operator.frames(moment);
        while let Some(asked) = self.preview.as_ref().and_then(Preview::next_request) {
            if moment.eyes.iter().all(Option::is_none) {
                asked.answer(Err("the recording has ended".to_owned()));
            } else {
                operator.answer(asked, moment);
            }
        }
    }

    fn line(&self) -> String {
        let mut line = format!("{:.1} Hz, latency {}", self.rate_hz, self.lately.2.text());
        for (side, (_, health)) in ["left", "right"].iter().zip(self.eyes.iter().flatten()) {
            let counts = health.counts();
            if counts.dropped + counts.corrupt > 0 {
                line += &format!(
                    ", {side} {} dropped {} damaged",
                    counts.dropped, counts.corrupt
                );
            }
        }
        if !self.note.is_empty() {
            line += &format!(", {}", self.note);
        }
        line
    }

    fn set_status(&self) {
        let Some(preview) = &self.preview else {
            return;
        };
        let statistics = &self.statistics;
        let state = if self.has_ended {
            "end of the recording".to_owned()
        } else if self.shots == 0 {
            "waiting for frames".to_owned()
        } else if self.note.is_empty() {
            format!("{:.1} Hz", self.rate_hz)
        } else {
            format!("{:.1} Hz, {}", self.rate_hz, self.note)
        };
        let status = json!({
            "state": state,
            "stitched": self.is_stitched,
            "ended": self.has_ended,
            "attitude": self.attitude,
            "operator": self.operator.as_ref().map(Operator::status),
            "session": self.session,
            "figures": {
                "frame rate": format!("{:.1} Hz", self.rate_hz),
                "latency": self.lately.2.text(),
                "work for a frame": self.work.text(),
                "frames": self.shots.to_string(),
                "skipped for newer ones": statistics.late.to_string(),
                "without a partner": format!(
                    "left {}, right {}", statistics.alone[0], statistics.alone[1]
                ),
                "right after left": format!(
                    "{:.2} ms", statistics.drift.mean_offset_ns() / 1e6
                ),
            },
        });
        preview.set_status(status);
    }

    /// Everything, for a person.
    pub fn text(&self) -> String {
        let seconds = self.start.elapsed().as_secs_f64();
        let statistics = &self.statistics;
        let mut text = format!(
            "{} frames in {seconds:.1} s, {:.1} Hz; work {}",
            self.shots,
            self.shots as f64 / seconds.max(1e-9),
            self.work.text()
        );
        if self.latency.count > 0 {
            text += &format!("; latency {}", self.latency.text());
        }
        if statistics.pairs > 0 {
            text += &format!(
                "\n{} skipped for newer ones, without a partner left {} right {}; right after left \
                 {:.2} ms (max {:.2})",
                statistics.late,
                statistics.alone[0],
                statistics.alone[1],
                statistics.drift.mean_offset_ns() / 1e6,
                statistics.drift.greatest_offset_ns() as f64 / 1e6,
            );
        }
        for (name, health) in self.eyes.iter().flatten() {
            let counts = health.counts();
            text += &format!(
                "\n{name}: {} frames, {} dropped, {} damaged, {} times back",
                counts.frames, counts.dropped, counts.corrupt, counts.reconnects
            );
            if counts.misstamped > 0 {
                text += &format!(", {} left out for a wrong time", counts.misstamped);
            }
            if counts.clock_jumps > 0 {
                text += &format!(", its clock jumped {} times", counts.clock_jumps);
            }
        }
        if self.undecodable > 0 {
            let count = self.undecodable;
            text += &format!("\n{count} left out, as a frame of them could not be decoded");
        }
        for recorded in self.recorded() {
            text += &format!("\n{recorded}");
        }
        text
    }

    /// Everything, for a script.
    pub fn json(&self) -> Value {
        let statistics = &self.statistics;
        let recordings: Vec<_> = self
            .recorded()
            .iter()
            .map(|recorded| {
                json!({
                    "name": recorded.name, "frames": recorded.frames,
                    "left_out": recorded.left_out, "lost": recorded.lost,
                    "failure": recorded.failure,
                })
            })
            .collect();
        let eye = |eye: &Option<(String, Arc<Health>)>| {
            eye.as_ref()
                .map(|(_, health)| counts_json(&health.counts()))
        };
        json!({
            "frames": self.shots,
            "seconds": self.start.elapsed().as_secs_f64(),
            "work_ms": self.work.json(),
            "latency_ms": (self.latency.count > 0).then(|| self.latency.json()),
            "late": statistics.late,
            "alone": statistics.alone,
            "offset_ms": {
                "mean": statistics.drift.mean_offset_ns() / 1e6,
                "max": statistics.drift.greatest_offset_ns() as f64 / 1e6,
            },
            "drift_ppm": statistics.drift.ppm(),
            "left": eye(&self.eyes[0]),
            "right": eye(&self.eyes[1]),
            "recordings": recordings,
            "undecodable": self.undecodable,
        })
    }
}
