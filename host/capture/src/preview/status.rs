//! How things are at the moment at which a client asks.

use std::sync::atomic::Ordering;

use serde_json::{Value, json};

use super::{Shared, lock};
use crate::monotonic_ns;

/// Without a frame for this long, or for three periods if those are longer, pictures are not live.
const STALE_NS: i64 = 1_500_000_000;

impl Shared {
    /// The capturing side's status with what is known only now: how old the newest frame is, which
    /// eyes are there, and whether this client may change anything.
    pub(super) fn status(&self, may_change: bool) -> String {
        let status = lock(&self.status).clone();
        let mut status = Value::clone(&status);
        let age_ns = monotonic_ns().saturating_sub(self.frame_ns.load(Ordering::Relaxed));
        let stale_ns = (self.fixed.period_ns)
            .and_then(|period| i64::try_from(period.saturating_mul(3)).ok())
            .map_or(STALE_NS, |three| three.max(STALE_NS));
        let has_ended = status["ended"] == json!(true);
        status["frame_age_ms"] = json!(age_ns / 1_000_000);
        status["stalled"] = json!(age_ns > stale_ns && !has_ended);
        status["may_change"] = json!(may_change);
        if !may_change && let Some(operator) = status["operator"].as_object_mut() {
            // Where files lie on this machine is nothing for those who only watch.
            operator.remove("folder");
        }
        status["takes_requests"] = json!(self.fixed.takes_requests);
        status["controls"] = json!(self.fixed.controls.as_ref().map(|controls| controls.text()));
        let eyes = lock(&self.eyes).clone();
        for (side, eye) in ["left", "right"].into_iter().zip(&eyes) {
            status[side] = eye.as_ref().map_or(Value::Null, |(name, health)| {
                let counts = health.counts();
                json!({
                    "source": name, "frames": counts.frames, "dropped": counts.dropped,
                    "corrupt": counts.corrupt, "reconnects": counts.reconnects,
                    "connected": counts.connected,
                })
            });
        }
        status.to_string()
    }
}
