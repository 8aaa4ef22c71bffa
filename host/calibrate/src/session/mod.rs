//! A session: pictures, and what was detected in them, kept so that no work is done twice.
//!
//! The session's folder holds one small JSON file a picture. Its name is a hash of all that the
//! detection depends on: the picture's bytes, the board, the markers' dictionary and the detectors'
//! version. So a changed picture is detected again, a renamed one is not, and several boards or
//! cameras may share a folder. Each file is written under another name and renamed when complete:
//! interrupted at any point, the next run goes on where this one ended.
//!
//! [`Shots`] are the pictures of one eye and what they show, [`CalibratedShots`] the eye that they give,
//! [`BothEyes`] two eyes and the rig that ties them together.

mod both;
mod cache;
mod check;
mod error;
mod eye;
mod look;
mod pairs;
mod pictures;
mod run;
mod shots;

pub use both::{BothEyes, BothEyesError, OtherModelError};
pub use check::{WrongBoard, check_board};
pub use error::SessionError;
pub use eye::{CalibratedShots, EyeFileError, Reported, ShotsCalibrateError, frame_size};
pub use look::{Load, LoadError, Targets, detect, mirrored};
pub use pairs::{Pairs, pair_by_name};
pub use pictures::{check_sizes, list};
pub use run::{Decode, Detected, Detections, Found, Outcome, Picture, Session, Wanted};
pub use shots::{Shots, ShotsError, UnfitShots};
