//! Two cameras as one: sources of frames, their pairing in time, recordings that survive a power
//! cut, live stitching.
//!
//! A [`FrameSource`] gives frames one after the other: a camera (module `device`, with the feature
//! `v4l2`), picture files ([`Pictures`]), a recording ([`Y4m`], [`Mjpeg`]) or something that makes
//! them up ([`Generated`]). What follows does not see a difference. [`Pairs`] brings two of them
//! together by the time at which their frames were taken. [`preview`] shows what comes out in a
//! browser.

mod ahead;
mod bayer;
mod believed;
mod beside;
mod clock;
mod convert;
mod depth;
mod description;
#[cfg(feature = "v4l2")]
pub mod device;
mod disk;
mod error;
mod format;
mod generated;
mod guidance;
mod health;
mod input;
mod jpeg;
mod live;
mod mjpeg;
mod operator;
mod pace;
mod pairing;
mod pairs;
mod pictures;
pub mod preview;
mod rate;
mod recorded;
mod recorder;
mod session;
mod side_by_side;
mod source;
mod stamp;
mod stop;
mod utc;
mod video;
mod writer;
mod y4m_file;
mod y4m_header;

pub use bayer::{Bayer, Depth, Mosaic};
pub use beside::beside_each_other;
pub use clock::{Judgement, Period, Stamp, is_plausible, judge, monotonic_ns};
pub use convert::{NotDecodable, to_core, to_rgb8};
pub use description::describe_recording;
pub use disk::{MIN_FREE_BYTES, check_free, free_bytes};
pub use error::CaptureError;
pub use format::{FrameFormat, Layout, UnknownLayout};
pub use generated::Generated;
pub use guidance::{Advice, Guidance};
pub use health::{Counts, Health};
pub use jpeg::{JpegDamage, JpegInfo, check_jpeg};
pub use live::LiveStitcher;
pub use mjpeg::Mjpeg;
pub use operator::{Moment, Operator, Recorded};
pub use pace::Pace;
pub use pairing::{Drift, Step, pair_all, step};
pub use pairs::{Late, Pair, PairStatistics, Pairs, Shot};
pub use pictures::{DeepPicture, PictureError, Pictures, decode_picture};
pub use rate::rate_of;
pub use recorder::{Recorder, VideoKind};
pub use session::{Coverage, Session, Verdict};
pub use side_by_side::{half_format, halves};
pub use source::{Frame, FrameSource, Next};
pub use stop::Stop;
pub use utc::utc;
pub use video::{conversion_advice, is_y4m, open_video};
pub use y4m_file::Y4m;
