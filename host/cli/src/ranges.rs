//! Which yaw and pitch a stitched picture shows, in words and for a script.

use nalgebra::Rotation3;
use serde_json::{Value, json};
use tectum_optics::OutputMap;

/// A line for a person; empty for pictures about an axis, which have no such borders.
pub fn range_line(map: &OutputMap) -> String {
    let Some(range) = map.range() else {
        return String::new();
    };
    let [right, left] = range.yaw_rad.map(f64::to_degrees);
    let [top, bottom] = range.pitch_rad.map(f64::to_degrees);
    let frame = if is_of_body(map) {
        ""
    } else {
        ", about the plane of both optical axes"
    };
    format!("shows   yaw {left:.2} to {right:.2}, pitch {top:.2} to {bottom:.2} degrees{frame}\n")
}

/// The same for a script; null for pictures about an axis.
pub fn range_json(map: &OutputMap) -> Value {
    let degrees = |range: [f64; 2]| range.map(f64::to_degrees);
    map.range().map_or(Value::Null, |range| {
        json!({
            "yaw_deg": degrees(range.yaw_rad),
            "pitch_deg": degrees(range.pitch_rad),
            "frame": if is_of_body(map) { "body" } else { "design" },
        })
    })
}

fn is_of_body(map: &OutputMap) -> bool {
    // Far above the rounding of a table's rotation.
    map.rotation.angle_to(&Rotation3::identity()) < 1e-6
}
