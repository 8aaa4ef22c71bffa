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
        /// World <- body, by frame.
        attitudes: Vec<Rotation3<f64>>,
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

    /// Scales of the world for a body that is turned as `file` says, frame by frame.
    pub fn of_world(
        tables: &Tables<'_>,
        step_deg: Option<f64>,
        file: &Path,
    ) -> anyhow::Result<Self> {
        let attitudes = Attitude::read_all(file)?;
        Ok(Self::World {
            map: output_map(tables),
            step_deg: step_deg.unwrap_or(USUAL_STEP_DEG),
            attitudes: attitudes.iter().map(Attitude::world_from_body).collect(),
        })
    }

    /// Draws on a frame, rows tightly packed.
    pub fn draw(&self, frame: u32, format: Format, picture: &mut [u8]) -> anyhow::Result<()> {
        match self {
            Self::Body(overlay) => draw_overlay(overlay, format, picture)?,
            Self::World {
                map,
                step_deg,
                attitudes,
            } => {
                let Some(world_from_body) = attitudes.get(frame as usize) else {
                    bail!("the attitude file has no row for frame {frame}");
                };
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

impl Attitude {
    /// Reads a file with a row for every frame.
    pub fn read_all(file: &Path) -> anyhow::Result<Vec<Self>> {
        let name = || file.display().to_string();
        let mut rows = csv::Reader::from_path(file).with_context(name)?;
        let mut attitudes = Vec::new();
        for row in rows.deserialize() {
            let row: Self = row.with_context(name)?;
            if row.frame as usize != attitudes.len() {
                bail!(
                    "{}: frame {} stands where frame {} should: needed is a row for every frame, \
                     from 0",
                    file.display(),
                    row.frame,
                    attitudes.len()
                );
            }
            row.check().with_context(name)?;
            attitudes.push(row);
        }
        Ok(attitudes)
    }

    /// Refuses numbers that are none, or that no body has.
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
