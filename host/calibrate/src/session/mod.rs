//! A session: pictures, and what was detected in them, kept so that no work is done twice.
//!
//! The session's folder holds one small JSON file a picture. Its name is a hash of all that the
//! detection depends on: the picture's bytes, the board, the markers' dictionary and the detectors'
//! version. So a changed picture is detected again, a renamed one is not, and several boards or
//! cameras may share a folder. Each file is written under another name and renamed when complete:
//! interrupted at any point, the next run goes on where this one ended.

mod cache;
mod check;
mod error;
mod pairs;
mod pictures;
mod run;

pub use check::{WrongBoard, check_board};
pub use error::SessionError;
pub use pairs::{Pairs, pair_by_name};
pub use pictures::{check_sizes, list};
pub use run::{Detected, Detections, Found, Outcome, Picture, Session, Wanted};
