//! What clients with the token may ask for, and how the capturing thread answers without waiting.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::{mpsc, oneshot};

/// Requests that wait for the capturing thread, at most.
const MAX_WAITING: usize = 8;
/// A request that is not taken up within this is withdrawn: no frames come.
const TAKE_TIME: Duration = Duration::from_secs(5);
/// What was taken up may have to wait for a slow disk for this long.
const ANSWER_TIME: Duration = Duration::from_secs(60);
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
    /// Note what the cameras' controls have been set to.
    NoteControls(String),
}

/// What became of a request, in words for the person who asked.
pub type Outcome = Result<String, String>;

/// A request that waits for its answer.
#[derive(Debug)]
pub struct Asked {
    /// What to do.
    pub request: Request,
    answer: oneshot::Sender<Outcome>,
    /// Taken up or withdrawn, whichever comes first.
    is_decided: Arc<AtomicBool>,
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
        let mut from = super::lock(&self.from);
        loop {
            let asked = from.try_recv().ok()?;
            let is_withdrawn = asked.is_decided.swap(true, Ordering::Relaxed);
            if !is_withdrawn && !asked.answer.is_closed() {
                return Some(asked);
            }
        }
    }

    /// For the server: hands a request on and waits for what becomes of it.
    pub async fn ask(&self, request: Request) -> Outcome {
        self.ask_within(request, TAKE_TIME, ANSWER_TIME).await
    }

    async fn ask_within(
        &self,
        request: Request,
        take_time: Duration,
        answer_time: Duration,
    ) -> Outcome {
        let (answer, mut outcome) = oneshot::channel();
        let is_decided = Arc::new(AtomicBool::new(false));
        let asked = Asked {
            request,
            answer,
            is_decided: is_decided.clone(),
        };
        if self.to.try_send(asked).is_err() {
            return Err("too many requests wait already; nothing was done".to_owned());
        }
        let mut answered = tokio::time::timeout(take_time, &mut outcome).await;
        if answered.is_err() {
            if !is_decided.swap(true, Ordering::Relaxed) {
                return Err("no frames are coming; nothing was done".to_owned());
            }
            answered = tokio::time::timeout(answer_time, outcome).await;
        }
        match answered {
            Ok(Ok(outcome)) => outcome,
            Ok(Err(_)) => Err("the program has not said what became of it".to_owned()),
            Err(_) => Err("this takes long; what becomes of it is not known yet".to_owned()),
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

#[cfg(test)]
mod tests {
    use std::future::{Future, poll_fn};
    use std::pin::pin;
    use std::task::Poll;

    use super::*;

    const SHORT: Duration = Duration::from_millis(20);
    const LONG: Duration = Duration::from_secs(60);

    /// Asks, and lets `act` play the capturing thread once the request is there.
    fn outcome(act: impl FnOnce(&Requests), answer_time: Duration) -> Outcome {
        let requests = Requests::new();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(async {
            let mut ask = pin!(requests.ask_within(Request::Snapshot, SHORT, answer_time));
            let is_waiting = poll_fn(|cx| Poll::Ready(ask.as_mut().poll(cx).is_pending()));
            assert!(is_waiting.await);
            act(&requests);
            ask.await
        })
    }

    #[test]
    fn what_is_taken_up_is_waited_for() {
        let late = |requests: &Requests| {
            let asked = requests.next().unwrap();
            std::thread::spawn(move || {
                std::thread::sleep(4 * SHORT);
                asked.answer(Ok("saved".to_owned()));
            });
        };
        assert_eq!(outcome(late, LONG), Ok("saved".to_owned()));
        let never = |requests: &Requests| std::mem::forget(requests.next());
        let reason = outcome(never, SHORT).unwrap_err();
        assert!(reason.contains("not known yet"), "{reason}");
        let ends = |requests: &Requests| drop(requests.next());
        let reason = outcome(ends, LONG).unwrap_err();
        assert!(reason.contains("has not said"), "{reason}");
    }

    #[test]
    fn what_nobody_takes_up_is_withdrawn() {
        let requests = Requests::new();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        let reason = runtime.block_on(requests.ask_within(Request::Snapshot, SHORT, LONG));
        assert!(reason.unwrap_err().contains("nothing was done"));
        assert!(requests.next().is_none());
    }
}
