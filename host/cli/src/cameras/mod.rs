//! Cameras, recordings, folders of pictures and the demo's pool as frames of two eyes.

mod attitude;
mod demo;
mod feed;
mod open;
mod outages;
mod scales;
pub mod showing;
mod stage;
pub mod streaming;
pub mod viewing;
mod watch;

pub use attitude::{Attitude, Attitudes, yaw_pitch_roll_deg};
pub use demo::demo_table;
pub use feed::Feed;
pub use open::{CameraOptions, is_pipe, open};
pub use scales::LiveScales;
pub use stage::{Limits, ViewArgs, stop_on_interrupt};
pub use watch::Watch;
