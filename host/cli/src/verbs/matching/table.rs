//! The comparison as text and for scripts.

use std::fmt::Write;

use serde_json::{Value, json};

use super::row::Row;

/// A line a row.
pub fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<11}{:<11}{:>16}{:>9}{:>14}{:>11}{:>13}{:>7}{:>13}\n",
        "pictures",
        "matcher",
        "features",
        "matches",
        "right",
        "by chance",
        "homography",
        "rays",
        "rotation off"
    );
    for row in rows {
        let off = row
            .rotation_off_rad
            .map_or("-".to_owned(), |rad| format!("{:.2} deg", rad.to_degrees()));
        let right = format!(
            "{} = {:.2}",
            row.consistency.count(),
            row.consistency.share()
        );
        let features = format!("{} {}", row.features[0], row.features[1]);
        let _ = writeln!(
            text,
            "{:<11}{:<11}{features:>16}{:>9}{right:>14}{:>11.2}{:>13.2}{:>7.2}{off:>13}",
            row.view_name(),
            row.name,
            row.matches.len(),
            row.consistency.chance,
            row.homography_share,
            row.ray_share,
        );
    }
    for row in rows {
        if let Some(sigma_rad) = row.rotation_sigma_rad {
            text += &sureness(row, sigma_rad.to_degrees());
        }
    }
    text
}

/// Standard error of a rotation that is good enough for a picture, degrees.
const SURE_DEG: f64 = 0.1;

/// What boards leave open.
fn sureness(row: &Row, sigma_deg: f64) -> String {
    let open = match sigma_deg <= SURE_DEG {
        true => "",
        false => {
            ": too few boards to tell a turn of the eyes from a shift; take more pairs, with the board \
             at other places, distances and tilts"
        }
    };
    match sigma_deg.is_finite() {
        true => format!(
            "{}: the rotation's standard error is {sigma_deg:.3} degrees{open}\n",
            row.name
        ),
        false => format!("{}: these boards fix no rotation{open}\n", row.name),
    }
}

/// A row for a script.
pub fn json(row: &Row) -> Value {
    json!({
        "pictures": row.view_name(),
        "matcher": row.name,
        "features": { "left": row.features[0], "right": row.features[1] },
        "matches": row.matches.len(),
        "right": row.consistency.count(),
        "right_share": row.consistency.share(),
        "chance_share": row.consistency.chance,
        "homography_share": row.homography_share,
        "ray_share": row.ray_share,
        "rotation_off_deg": row.rotation_off_rad.map(f64::to_degrees),
        "rotation_standard_error_deg": row.rotation_sigma_rad
            .filter(|sigma| sigma.is_finite())
            .map(f64::to_degrees),
    })
}
