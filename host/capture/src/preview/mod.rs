//! A preview in the browser: on the loopback interface unless told otherwise, and read-only but for
//! clients that have the token.
//!
//! The capturing thread never waits for a client: it leaves the newest pictures where clients fetch
//! them, ten times a second and only while someone looks, and takes requests from a queue. A picture
//! is encoded when first asked for, once for all clients.

mod access;
mod addresses;
mod pages;
mod picture;
mod places;
mod requests;
mod server;
mod status;

pub use picture::{Picture, Snapshot};
pub use requests::{Asked, Outcome, Request};

use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::{Value, json};
use tokio::sync::watch;

use self::access::Access;
use self::requests::Requests;
use crate::{CaptureError, Health, monotonic_ns};

/// From one published picture to the next, at least.
const PUBLISH_EVERY_NS: i64 = 100_000_000;
/// Nobody is looking when nobody asked for this long.
const LOOKING_NS: i64 = 5_000_000_000;

/// Answers a client's question about a direction: the query's pairs in, JSON or a reason out.
pub type Answer = Box<dyn Fn(&[(String, String)]) -> Result<String, String> + Send + Sync>;

/// Draws scales for a picture that is shown so many px wide, with lines so many degrees apart: an
/// SVG document, or a reason.
pub type DrawScales = Box<dyn Fn(u16, f64) -> Result<String, String> + Send + Sync>;

/// Name and counters of each eye, left and right, which is there.
pub type Eyes = [Option<(String, Arc<Health>)>; 2];

/// Exposure and gain of the cameras, changed on the server's thread.
pub trait Controls: Send + Sync {
    /// What the cameras are set to now, as the page shows it.
    fn text(&self) -> String;

    /// Sets the exposure time of all eyes, in 0.1 ms, and turns the automatic off.
    ///
    /// # Errors
    /// Why not, in words for the operator.
    fn set_exposure(&self, exposure: i64) -> Outcome;

    /// Gives both eyes the left eye's exposure, gain and white balance and keeps them.
    ///
    /// # Errors
    /// Why not, in words for the operator.
    fn lock(&self) -> Outcome;
}

/// What does not change while a preview runs.
#[derive(Default)]
pub struct Fixed {
    /// Which direction a pixel shows.
    pub direction: Option<Answer>,
    /// Scales of the stitched picture.
    pub scales: Option<DrawScales>,
    /// The cameras' controls, where there are any.
    pub controls: Option<Box<dyn Controls>>,
    /// Whether the capturing thread answers requests ([`Preview::next_request`]).
    pub takes_requests: bool,
    /// Which eyes there should be.
    pub eyes: Eyes,
    /// From one frame to the next, ns, as it should be.
    pub period_ns: Option<u64>,
}

impl std::fmt::Debug for Fixed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fixed").finish_non_exhaustive()
    }
}

/// Shared by the capturing thread and the server.
struct Shared {
    fixed: Fixed,
    access: Access,
    requests: Requests,
    eyes: Mutex<Eyes>,
    newest: watch::Sender<Option<Arc<Snapshot>>>,
    /// Replaced as a whole, so that neither side holds the lock for longer than a copy of a pointer.
    status: Mutex<Arc<Value>>,
    frame_ns: AtomicI64,
    asked_ns: AtomicI64,
    published_ns: AtomicI64,
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
        let failed = |source: io::Error| CaptureError::Driver {
            name: address.to_string(),
            doing: "serving the preview (is another program using the port?)",
            source,
        };
        let shared = Arc::new(Shared {
            eyes: Mutex::new(fixed.eyes.clone()),
            fixed,
            access: Access::new().map_err(failed)?,
            requests: Requests::new(),
            newest: watch::Sender::new(None),
            status: Mutex::new(Arc::new(json!({}))),
            frame_ns: AtomicI64::new(monotonic_ns()),
            asked_ns: AtomicI64::new(i64::MIN / 2),
            published_ns: AtomicI64::new(i64::MIN / 2),
        });
        let address = server::start(address, shared.clone()).map_err(failed)?;
        Ok(Self { shared, address })
    }

    /// Where it is served.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What to tell the person who started it: the addresses that can be opened, a line each that
    /// begins with `preview: `, and who can do what with them.
    pub fn notice(&self) -> String {
        let token = self.shared.access.token();
        let suffix = if self.takes_changes() {
            format!("#token={token}")
        } else {
            String::new()
        };
        let mut lines: Vec<String> = addresses::reachable(self.address)
            .iter()
            .map(|address| format!("preview: http://{address}/{suffix}"))
            .collect();
        if !self.address.ip().is_loopback() {
            lines.push(
                "warning: everyone on the network can watch at this address, unencrypted"
                    .to_owned(),
            );
        }
        if self.takes_changes() {
            lines.push(
                "The part after # allows to save, record and set the cameras; without it the page \
                 can only be read."
                    .to_owned(),
            );
        }
        lines.join("\n")
    }

    /// Whether the page can change anything at all.
    fn takes_changes(&self) -> bool {
        self.shared.fixed.takes_requests || self.shared.fixed.controls.is_some()
    }

    /// What a client with the token asked for; for the capturing thread, at each frame.
    pub fn next_request(&self) -> Option<Asked> {
        self.shared.requests.next()
    }

    /// Whether a new picture is due: someone looks, and the last one is old enough.
    pub fn is_due(&self) -> bool {
        let now = monotonic_ns();
        let since = |then: &AtomicI64| now.saturating_sub(then.load(Ordering::Relaxed));
        since(&self.shared.asked_ns) < LOOKING_NS
            && since(&self.shared.published_ns) >= PUBLISH_EVERY_NS
    }

    /// A frame came, published or not: the pictures are live.
    pub fn frame_came(&self) {
        self.shared
            .frame_ns
            .store(monotonic_ns(), Ordering::Relaxed);
    }

    /// Leaves pictures for clients to fetch.
    pub fn publish(&self, snapshot: Snapshot) {
        let now = monotonic_ns();
        self.shared.published_ns.store(now, Ordering::Relaxed);
        self.shared.newest.send_replace(Some(Arc::new(snapshot)));
    }

    /// Leaves the status for clients to fetch: an object with `state`, `stitched`, `figures` and
    /// whatever else the page knows. State of the eyes and of the connection is added when it is
    /// fetched.
    pub fn set_status(&self, status: Value) {
        *lock(&self.shared.status) = Arc::new(status);
    }

    /// The eyes come from other sources from now on, as when a recording begins again.
    pub fn set_eyes(&self, eyes: Eyes) {
        *lock(&self.shared.eyes) = eyes;
    }
}

/// Locks, though a thread broke off while it held the lock.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
