//! What a recording was made with, beside it.

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::{FrameFormat, monotonic_ns};

/// Describes a recording that begins now: its clock against the time of day, its rate (frames, in
/// seconds) and both eyes with name, format and what else is known.
///
/// Frames carry `monotonic_ns`; the time of day at which one was taken is
/// `unix_ns + (time - monotonic_ns)`.
pub fn describe_recording(rate: [u32; 2], eyes: [Option<(&str, FrameFormat, Value)>; 2]) -> Value {
    let unix = SystemTime::now().duration_since(UNIX_EPOCH);
    let unix_ns = unix.map_or(0, |since| since.as_nanos() as i64);
    let eye = |eye: Option<(&str, FrameFormat, Value)>| {
        eye.map(|(name, format, facts)| {
            json!({
                "name": name,
                "pixel_format": format.layout.to_string(),
                "size_px": format.size_px,
                "full_range": format.full_range,
                "facts": facts,
            })
        })
    };
    let [left, right] = eyes;
    json!({
        "clock": { "monotonic_ns": monotonic_ns(), "unix_ns": unix_ns },
        "rate": rate,
        "left": eye(left),
        "right": eye(right),
    })
}
