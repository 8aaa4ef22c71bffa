//! Scales on a stream: of the body, or of the world that the body turns in.

use std::path::Path;

use anyhow::{Context, bail};
use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};
use tectum_bake::{Format, Scales, draw_overlay, output_map};
use tectum_core::{Overlay, Tables};
use tectum_optics::OutputMap;
use tectum_scene::camera::Pose;

/// From line to line of scales, degrees, where nothing else is said.
const USUAL_STEP_DEG: f64 = 30.0;

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

/// What is drawn on each frame.
pub enum LiveScales<'t> {
    /// The same lines always.
    Body(Overlay<'t>),
    /// Lines of the world's yaw and pitch, which move through the picture.
    World {
        /// The pictures' projection.
        map: OutputMap,
        /// From line to line, degrees.
        step_deg: f64,
        /// World <- body over time.
        attitudes: Attitudes,
    },
}

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

impl<'t> LiveScales<'t> {
    /// Scales of the body: every `step_deg` or, if that is not said, the table's own if it has any.
    pub fn of_body(tables: &Tables<'t>, step_deg: Option<f64>) -> anyhow::Result<Self> {
        if let (None, Some(overlay)) = (step_deg, tables.overlay()) {
            return Ok(Self::Body(overlay));
        }
        let map = output_map(tables);
        let scales = Scales::new(&map, step_deg.unwrap_or(USUAL_STEP_DEG))?;
        // Once a run, a few KB: proven once, and lent to every frame.
        let bytes: &'static [u8] = Box::leak(scales.bytes.into_boxed_slice());
        Ok(Self::Body(Overlay::parse(bytes, map.size_px)?))
    }

    /// Scales of the world for a body that is turned as `file` says, by the time since the first
    /// frame.
    pub fn of_world(
        tables: &Tables<'_>,
        step_deg: Option<f64>,
        file: &Path,
    ) -> anyhow::Result<Self> {
        let attitudes = Attitudes::read(file)?;
        Ok(Self::World {
            map: output_map(tables),
            step_deg: step_deg.unwrap_or(USUAL_STEP_DEG),
            attitudes,
        })
    }

    /// The time of a frame of a source for which time plays no part, s: that of its row.
    pub fn time_of_frame_s(&self, frame: i64) -> anyhow::Result<f64> {
        match self {
            Self::Body(_) => Ok(0.0),
            Self::World { attitudes, .. } => {
                let mut rows = attitudes.rows.iter();
                match rows.find(|row| i64::from(row.frame) == frame) {
                    Some(row) => Ok(row.time_s),
                    None => bail!("the attitude file has no row for frame {frame}"),
                }
            }
        }
    }

    /// Draws on a frame taken `time_s` after the first, rows tightly packed.
    pub fn draw(&self, time_s: f64, format: Format, picture: &mut [u8]) -> anyhow::Result<()> {
        match self {
            Self::Body(overlay) => draw_overlay(overlay, format, picture)?,
            Self::World {
                map,
                step_deg,
                attitudes,
            } => {
                let world_from_body = attitudes.at(time_s)?;
                let turned = OutputMap {
                    rotation: world_from_body * map.rotation,
                    ..*map
                };
                Scales::new(&turned, *step_deg)?.draw(&turned, format, picture)?;
            }
        }
        Ok(())
    }
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
    fn read(file: &Path) -> anyhow::Result<Self> {
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

    /// The attitude at a time: between two rows, in proportion; up to the distance of two rows
    /// before the first and after the last, theirs.
    fn at(&self, time_s: f64) -> anyhow::Result<Rotation3<f64>> {
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
