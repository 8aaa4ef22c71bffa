//! What clients with the token may ask for, and how the capturing thread answers without waiting.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{mpsc, oneshot};

/// Requests that wait for the capturing thread, at most.
const MAX_WAITING: usize = 8;
/// A request that is not answered within this is withdrawn: no frames come.
const ANSWER_TIME: Duration = Duration::from_secs(5);
/// Longest name of a mark, characters.
const MAX_NAME: usize = 80;

/// Something to do with the frames that come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Request {
    /// Save this moment's pictures.
    Snapshot,
    /// Begin to record, or end it.
    Record(bool),
    /// Note this moment under a name.
    Mark(String),
}

/// What became of a request, in words for the person who asked.
pub type Outcome = Result<String, String>;

/// A request that waits for its answer.
#[derive(Debug)]
pub struct Asked {
    /// What to do.
    pub request: Request,
    answer: oneshot::Sender<Outcome>,
}

impl Asked {
    /// Answers. Never waits.
    pub fn answer(self, outcome: Outcome) {
        // Who asked may have gone.
        let _ = self.answer.send(outcome);
    }
}

/// The way from clients to the capturing thread.
#[derive(Debug)]
pub(super) struct Requests {
    to: mpsc::Sender<Asked>,
    from: Mutex<mpsc::Receiver<Asked>>,
}

impl Requests {
    pub fn new() -> Self {
        let (to, from) = mpsc::channel(MAX_WAITING);
        Self {
            to,
            from: Mutex::new(from),
        }
    }

    /// For the capturing thread: a request whose client still waits.
    pub fn next(&self) -> Option<Asked> {
        let mut from = self.from.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let asked = from.try_recv().ok()?;
            if !asked.answer.is_closed() {
                return Some(asked);
            }
        }
    }

    /// For the server: hands a request on and waits for what becomes of it.
    pub async fn ask(&self, request: Request) -> Outcome {
        let (answer, outcome) = oneshot::channel();
        let asked = Asked { request, answer };
        if self.to.try_send(asked).is_err() {
            return Err("too many requests wait already; nothing was done".to_owned());
        }
        match tokio::time::timeout(ANSWER_TIME, outcome).await {
            Ok(Ok(outcome)) => outcome,
            _ => Err("no frames are coming; nothing was done".to_owned()),
        }
    }
}

/// A name as it may stand in a file of marks and on the page: one line, not too long.
pub(super) fn clean_name(name: &str) -> String {
    let printable = name.chars().filter(|c| !c.is_control());
    printable
        .take(MAX_NAME)
        .collect::<String>()
        .trim()
        .to_owned()
}
