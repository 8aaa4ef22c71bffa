//! Cameras, recordings, folders of pictures and the demo's pool as frames of two eyes.

mod demo;
mod feed;
mod open;
mod scales;
pub mod showing;
mod stage;
pub mod streaming;
mod turns;
pub mod viewing;
mod watch;

pub use demo::demo_table;
pub use feed::Feed;
pub use open::{CameraOptions, open};
pub use scales::{Attitude, LiveScales};
pub use stage::{Limits, ViewArgs, stop_on_interrupt};
pub use turns::Turns;
pub use watch::Watch;
