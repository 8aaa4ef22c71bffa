//! How the body is turned over time, as an attitude file has it.

use std::path::Path;

use anyhow::{Context, bail};
use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};
use tectum_scene::camera::Pose;

/// A time this close to a row's, as a share of the step to the next, is that row's.
const SAME_SHARE: f64 = 1e-3;
/// A single row reaches at least this far, s.
const MIN_REACH_S: f64 = 1e-3;
/// Turns closer to half a turn than this, rad, have no shortest way.
const NO_WAY_RAD: f64 = 1e-6;

/// Greatest time, position and angle of an attitude file; angles may count turns.
const MAX_TIME_S: f64 = 1e9;
const MAX_POSITION_M: f64 = 1e6;
const MAX_ANGLE_DEG: f64 = 36_000.0;

/// A row of an attitude file: where the body is at a frame and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Attitude {
    /// Frame, from 0.
    pub frame: u32,
    /// Since the first frame, s.
    pub time_s: f64,
    /// Position in the world, m.
    pub x_m: f64,
    /// To the left.
    pub y_m: f64,
    /// Up.
    pub z_m: f64,
    /// Left positive.
    pub yaw_deg: f64,
    /// Up negative.
    pub pitch_deg: f64,
    /// Right side down positive.
    pub roll_deg: f64,
}

/// How a body turns over time.
pub struct Attitudes {
    rows: Vec<Row>,
}

/// How a body is turned at a moment.
struct Row {
    /// Frame, as the file counts.
    frame: u32,
    /// Since the first frame, s.
    time_s: f64,
    /// World <- body.
    world_from_body: Rotation3<f64>,
}

impl Attitudes {
    /// Reads a file whose rows' times increase.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let name = || file.display().to_string();
        let mut reader = csv::Reader::from_path(file).with_context(name)?;
        let mut rows: Vec<Row> = Vec::new();
        for row in reader.deserialize() {
            let row: Attitude = row.with_context(name)?;
            let is_later = rows.last().is_none_or(|before| row.time_s > before.time_s);
            if !row.time_s.is_finite() || !is_later {
                bail!(
                    "{}: row of frame {}: needed are numbers, and times that increase",
                    name(),
                    row.frame
                );
            }
            row.check().with_context(name)?;
            rows.push(Row {
                frame: row.frame,
                time_s: row.time_s,
                world_from_body: row.world_from_body(),
            });
        }
        if rows.is_empty() {
            bail!("{}: no rows", name());
        }
        Ok(Self { rows })
    }

    /// Time of a frame that came `since_ns` after the first, s. Where time plays no part `since_ns`
    /// counts frames, and the time is that of the frame's row.
    pub fn time_s(&self, since_ns: i64, has_time: bool) -> anyhow::Result<f64> {
        if has_time {
            return Ok(since_ns as f64 / 1e9);
        }
        let frame = since_ns;
        match self.rows.iter().find(|row| i64::from(row.frame) == frame) {
            Some(row) => Ok(row.time_s),
            None => bail!("the attitude file has no row for frame {frame}"),
        }
    }

    /// World <- body so long after the first frame: between two rows, in proportion; up to the
    /// distance of two rows before the first and after the last, theirs.
    pub fn at(&self, time_s: f64) -> anyhow::Result<Rotation3<f64>> {
        let after = self.rows.partition_point(|row| row.time_s < time_s);
        let before = after.checked_sub(1).and_then(|i| self.rows.get(i));
        match (before, self.rows.get(after)) {
            (Some(before), Some(after)) => {
                let share = (time_s - before.time_s) / (after.time_s - before.time_s);
                let [from, to] = [before, after].map(|row| row.world_from_body);
                let nearer = if share < 0.5 { from } else { to };
                // Times in recordings are whole nanoseconds, those of rows are rounded.
                if share.min(1.0 - share) < SAME_SHARE {
                    return Ok(nearer);
                }
                Ok(from.try_slerp(&to, share, NO_WAY_RAD).unwrap_or(nearer))
            }
            (Some(row), None) | (None, Some(row))
                if (time_s - row.time_s).abs() <= self.longest_step_s() =>
            {
                Ok(row.world_from_body)
            }
            _ => bail!("the attitude file has no row for {time_s:.3} s after the first frame"),
        }
    }

    fn longest_step_s(&self) -> f64 {
        let steps = self.rows.windows(2);
        let steps = steps.map(|two| two[1].time_s - two[0].time_s);
        steps.fold(MIN_REACH_S, f64::max)
    }
}

impl Attitude {
    /// Refuses infinite and undefined numbers, and those that no body has.
    fn check(&self) -> anyhow::Result<()> {
        let (metres, degrees) = (
            [self.x_m, self.y_m, self.z_m],
            [self.yaw_deg, self.pitch_deg, self.roll_deg],
        );
        let is_sound = self.time_s.abs() <= MAX_TIME_S
            && metres.iter().all(|m| m.abs() <= MAX_POSITION_M)
            && degrees.iter().all(|deg| deg.abs() <= MAX_ANGLE_DEG);
        if !is_sound {
            bail!(
                "frame {}: needed are finite numbers, angles of at most {MAX_ANGLE_DEG} degrees, \
                 positions of at most {MAX_POSITION_M} m",
                self.frame
            );
        }
        Ok(())
    }

    fn world_from_body(&self) -> Rotation3<f64> {
        let pose = Pose {
            yaw_deg: self.yaw_deg,
            pitch_deg: self.pitch_deg,
            roll_deg: self.roll_deg,
            ..Pose::default()
        };
        // A sine of -0 would put lines at 180 degrees to the other border.
        Rotation3::from_matrix_unchecked(pose.world_from_body().map(|v| v + 0.0))
    }
}

/// Yaw, pitch and roll of a turn, degrees, with the signs of [`Attitude`].
pub fn yaw_pitch_roll_deg(world_from_body: &Rotation3<f64>) -> [f64; 3] {
    let (roll, pitch, yaw) = world_from_body.euler_angles();
    // What is left of rounding in the rotation is nothing that a file said.
    [yaw, pitch, roll].map(|rad| (rad.to_degrees() * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(frame: u32, time_s: f64, [yaw_deg, pitch_deg, roll_deg]: [f64; 3]) -> Row {
        let attitude = Attitude {
            frame,
            time_s,
            x_m: 0.0,
            y_m: 0.0,
            z_m: 0.0,
            yaw_deg,
            pitch_deg,
            roll_deg,
        };
        Row {
            frame,
            time_s,
            world_from_body: attitude.world_from_body(),
        }
    }

    #[test]
    fn angles_come_out_as_they_went_in() {
        for angles in [
            [0.0, 0.0, 0.0],
            [12.5, -3.0, 0.0],
            [-170.0, 40.25, -60.0],
            [90.0, -89.0, 179.0],
        ] {
            let turn = row(0, 0.0, angles).world_from_body;
            assert_eq!(yaw_pitch_roll_deg(&turn), angles);
        }
    }

    #[test]
    fn between_rows_turns_are_in_proportion_and_far_from_all_rows_there_is_none() {
        let rows = [(0, 0.0, 1.0), (1, 0.5, 2.0), (2, 1.0, 4.0)];
        let rows = rows.map(|(frame, time_s, yaw)| row(frame, time_s, [yaw, 0.0, 0.0]));
        let attitudes = Attitudes { rows: rows.into() };
        let yaw = |time_s| {
            let turn = attitudes.at(time_s).ok()?;
            Some(yaw_pitch_roll_deg(&turn)[0])
        };
        for (time_s, wanted) in [
            (-0.4, Some(1.0)),
            (0.0, Some(1.0)),
            (0.1, Some(1.2)),
            (0.5, Some(2.0)),
            (0.75, Some(3.0)),
            (1.5, Some(4.0)),
            (-0.6, None),
            (9.0, None),
        ] {
            assert_eq!(yaw(time_s), wanted, "{time_s}");
        }
        assert_eq!(attitudes.time_s(250_000_000, true).unwrap(), 0.25);
        assert_eq!(attitudes.time_s(2, false).unwrap(), 1.0);
        assert!(attitudes.time_s(3, false).is_err());
    }
}
