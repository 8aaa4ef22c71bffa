//! How the body is turned, beside the pictures on the page.

use std::path::Path;

use serde_json::{Value, json};

use super::Attitude;

/// Rows of an attitude file, by their time.
pub struct Turns(Vec<Attitude>);

impl Turns {
    /// Reads a file with a row for every frame.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let mut rows = Attitude::read_all(file)?;
        rows.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Ok(Self(rows))
    }

    /// So long after the first frame, s, by the nearest row; nothing without rows.
    pub fn at(&self, time_s: f64) -> Value {
        let after = self.0.partition_point(|row| row.time_s < time_s);
        let around = self.0[after.saturating_sub(1)..].iter().take(2);
        let distance = |row: &&Attitude| (row.time_s - time_s).abs();
        let nearest = around.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(Value::Null, |row| {
            json!({
                "yaw_deg": row.yaw_deg, "pitch_deg": row.pitch_deg, "roll_deg": row.roll_deg,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_row_is_shown_before_between_and_after_all() {
        let row = |frame: u32, time_s, yaw_deg| Attitude {
            frame,
            time_s,
            x_m: 0.0,
            y_m: 0.0,
            z_m: 0.0,
            yaw_deg,
            pitch_deg: 0.0,
            roll_deg: 0.0,
        };
        let turns = Turns(vec![row(0, 0.0, 1.0), row(1, 0.5, 2.0), row(2, 1.0, 3.0)]);
        for (time_s, yaw_deg) in [(-9.0, 1.0), (0.1, 1.0), (0.3, 2.0), (0.76, 3.0), (9.0, 3.0)] {
            assert_eq!(turns.at(time_s)["yaw_deg"], yaw_deg, "{time_s}");
        }
        assert!(Turns(Vec::new()).at(0.0).is_null());
    }
}
