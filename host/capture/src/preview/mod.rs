//! A preview in the browser: read-only, on the loopback interface unless told otherwise.
//!
//! The capturing thread never waits for a client: it leaves the newest pictures where clients fetch
//! them, ten times a second and only while someone looks. A picture is encoded when first asked
//! for, once for all clients.

mod pages;
mod picture;
mod server;

pub use picture::{Picture, Snapshot};

use std::net::SocketAddr;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::{Value, json};
use tokio::sync::watch;

use crate::{CaptureError, Health, monotonic_ns};

/// From one published picture to the next, at least.
const PUBLISH_EVERY_NS: i64 = 100_000_000;
/// Nobody is looking when nobody asked for this long.
const LOOKING_NS: i64 = 5_000_000_000;
/// A status this old is not how things are: frames have stopped.
const STALE_NS: i64 = 2_000_000_000;

/// Answers a client's question about a direction: the query's pairs in, JSON or a reason out.
pub type Answer = Box<dyn Fn(&[(String, String)]) -> Result<String, String> + Send + Sync>;

/// What does not change while a preview runs.
pub struct Fixed {
    /// Which direction a pixel shows.
    pub direction: Option<Answer>,
    /// PNG of the stitched picture's size, transparent but for scales.
    pub scales_png: Option<Vec<u8>>,
    /// Name and counters of each eye, left and right, which is there.
    pub eyes: [Option<(String, Arc<Health>)>; 2],
}

impl std::fmt::Debug for Fixed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fixed").finish_non_exhaustive()
    }
}

/// Shared by the capturing thread and the server.
struct Shared {
    fixed: Fixed,
    newest: watch::Sender<Option<Arc<Snapshot>>>,
    status: Mutex<Value>,
    status_ns: AtomicI64,
    asked_ns: AtomicI64,
    published_ns: AtomicI64,
    is_loopback: bool,
}

/// A running preview; it ends with the program.
pub struct Preview {
    shared: Arc<Shared>,
    address: SocketAddr,
}

impl std::fmt::Debug for Preview {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Preview")
            .field("address", &self.address)
            .finish_non_exhaustive()
    }
}

impl Preview {
    /// Begins to serve at `address`; port 0 takes any that is free.
    ///
    /// # Errors
    /// [`CaptureError::Driver`] if the address cannot be had.
    pub fn serve(address: SocketAddr, fixed: Fixed) -> Result<Self, CaptureError> {
        let shared = Arc::new(Shared {
            fixed,
            newest: watch::Sender::new(None),
            status: Mutex::new(json!({})),
            status_ns: AtomicI64::new(monotonic_ns()),
            asked_ns: AtomicI64::new(i64::MIN / 2),
            published_ns: AtomicI64::new(i64::MIN / 2),
            is_loopback: address.ip().is_loopback(),
        });
        let address =
            server::start(address, shared.clone()).map_err(|source| CaptureError::Driver {
                name: address.to_string(),
                doing: "serving the preview (take another port with --view ADDRESS:PORT)",
                source,
            })?;
        Ok(Self { shared, address })
    }

    /// Where it is.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Whether a new picture is due: someone looks, and the last one is old enough.
    pub fn is_due(&self) -> bool {
        let now = monotonic_ns();
        let since = |then: &AtomicI64| now.saturating_sub(then.load(Ordering::Relaxed));
        since(&self.shared.asked_ns) < LOOKING_NS
            && since(&self.shared.published_ns) >= PUBLISH_EVERY_NS
    }

    /// Leaves pictures for clients to fetch.
    pub fn publish(&self, snapshot: Snapshot) {
        let now = monotonic_ns();
        self.shared.published_ns.store(now, Ordering::Relaxed);
        self.shared.newest.send_replace(Some(Arc::new(snapshot)));
    }

    /// Leaves the status for clients to fetch: an object with `state`, `stitched`, `coverage` and
    /// `figures`. The eyes' own state is added when it is fetched.
    pub fn set_status(&self, status: Value) {
        let shared = &self.shared;
        shared.status_ns.store(monotonic_ns(), Ordering::Relaxed);
        *shared.status.lock().unwrap_or_else(PoisonError::into_inner) = status;
    }
}

impl Shared {
    fn status(&self) -> String {
        let status = self.status.lock().unwrap_or_else(PoisonError::into_inner);
        let mut status = status.clone();
        let age_ns = monotonic_ns().saturating_sub(self.status_ns.load(Ordering::Relaxed));
        if age_ns > STALE_NS {
            status["state"] = json!(format!("no new frames for {} s", age_ns / 1_000_000_000));
        }
        for (side, eye) in ["left", "right"].into_iter().zip(&self.fixed.eyes) {
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
