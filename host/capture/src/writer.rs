//! Writing to a file on a thread of its own, so that a slow disk does not cost frames.

use std::collections::VecDeque;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::{CaptureError, MIN_FREE_BYTES, check_free};

/// What is recorded reaches the disk itself at least this often; a power cut loses no more.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// What may wait for the disk, bytes: about a second of two large cameras. A disk that is slow for
/// longer makes the cameras wait, whose lost frames are counted.
const MAX_WAITING_BYTES: usize = 64 << 20;

/// A file that is written in whole pieces, in order, by another thread.
#[derive(Debug)]
pub(crate) struct Writer {
    path: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    pieces: VecDeque<Vec<u8>>,
    waiting_bytes: usize,
    written: u64,
    error: Option<CaptureError>,
    has_failed: bool,
    is_closed: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // The state is whole after every statement.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'s>(&self, state: MutexGuard<'s, State>) -> MutexGuard<'s, State> {
        self.changed
            .wait(state)
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Writer {
    /// Begins to write `file`, whose name is `path`.
    pub fn new(file: File, path: &Path) -> Self {
        let shared = Arc::<Shared>::default();
        let (of_thread, of_file) = (shared.clone(), path.to_owned());
        let thread = std::thread::spawn(move || write_all(&of_thread, file, &of_file));
        Self {
            path: path.to_owned(),
            shared,
            thread: Some(thread),
        }
    }

    /// Hands a piece over; waits where too much is waiting for the disk.
    ///
    /// # Errors
    /// What went wrong with an earlier piece.
    pub fn push(&self, piece: Vec<u8>) -> Result<(), CaptureError> {
        let mut state = self.shared.lock();
        // A single piece may be larger than the bound.
        while state.waiting_bytes > 0
            && state.waiting_bytes + piece.len() > MAX_WAITING_BYTES
            && !state.has_failed
        {
            state = self.shared.wait(state);
        }
        if state.has_failed {
            return Err(state.error.take().unwrap_or_else(|| CaptureError::File {
                path: self.path.clone(),
                why: "an earlier frame could not be written".to_owned(),
            }));
        }
        state.waiting_bytes += piece.len();
        state.pieces.push_back(piece);
        self.shared.changed.notify_all();
        Ok(())
    }

    /// Waits until everything is on the disk; how many pieces are.
    ///
    /// # Errors
    /// What went wrong with any piece that has not been told yet.
    pub fn finish(&mut self) -> (u64, Result<(), CaptureError>) {
        self.shared.lock().is_closed = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let mut state = self.shared.lock();
        (state.written, state.error.take().map_or(Ok(()), Err))
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}

fn write_all(shared: &Shared, mut file: File, path: &Path) {
    let (mut bytes, mut synced) = (0, Instant::now());
    loop {
        let piece = {
            let mut state = shared.lock();
            loop {
                if let Some(piece) = state.pieces.pop_front() {
                    break Some(piece);
                }
                if state.is_closed {
                    break None;
                }
                state = shared.wait(state);
            }
        };
        let Some(piece) = piece else {
            break;
        };
        let done = write_one(&mut file, path, &piece, &mut synced);
        let mut state = shared.lock();
        state.waiting_bytes -= piece.len();
        match done {
            Ok(()) => {
                bytes += piece.len() as u64;
                state.written += 1;
            }
            Err((error, is_written)) => {
                // Half a piece is of no use, and would be taken for a damaged one.
                if is_written {
                    state.written += 1;
                } else {
                    let _ = file.set_len(bytes);
                }
                state.error = Some(error);
                state.has_failed = true;
                state.pieces.clear();
                state.waiting_bytes = 0;
            }
        }
        let has_failed = state.has_failed;
        drop(state);
        shared.changed.notify_all();
        if has_failed {
            return;
        }
    }
    if let Err(error) = file.sync_data() {
        let mut state = shared.lock();
        state.error.get_or_insert(CaptureError::io(path, error));
    }
}

/// Writes a piece; an error comes with whether the piece is in the file all the same.
fn write_one(
    file: &mut File,
    path: &Path,
    piece: &[u8],
    synced: &mut Instant,
) -> Result<(), (CaptureError, bool)> {
    let io = |error| CaptureError::io(path, error);
    file.write_all(piece).map_err(|error| (io(error), false))?;
    if synced.elapsed() >= SYNC_EVERY {
        file.sync_data().map_err(|error| (io(error), true))?;
        *synced = Instant::now();
        check_free(path, MIN_FREE_BYTES).map_err(|error| (error, true))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_written_in_order_and_all_are_there_at_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        let mut writer = Writer::new(File::create(&path).unwrap(), &path);
        let mut wanted = Vec::new();
        for i in 0..200_u8 {
            let piece = vec![i; usize::from(i) * 7];
            wanted.extend_from_slice(&piece);
            writer.push(piece).unwrap();
        }
        let (written, done) = writer.finish();
        done.unwrap();
        assert_eq!(written, 200);
        assert!(std::fs::read(&path).unwrap() == wanted);
    }

    #[test]
    fn a_disk_that_fails_is_told_and_never_waited_for() {
        // A device that is always full.
        let path = Path::new("/dev/full");
        let file = File::options().write(true).open(path).unwrap();
        let mut writer = Writer::new(file, path);
        let mut errors = 0;
        for _ in 0..4 {
            errors += u32::from(writer.push(vec![0; MAX_WAITING_BYTES / 2]).is_err());
        }
        let (written, done) = writer.finish();
        errors += u32::from(done.is_err());
        assert!(
            written == 0 && errors > 0,
            "{written} written, {errors} errors"
        );
    }
}
