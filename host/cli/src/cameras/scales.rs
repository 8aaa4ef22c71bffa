//! Scales on a stream: of the body, or of the world that the body turns in.

use std::path::Path;

use tectum_bake::{Format, Scales, draw_overlay, output_map};
use tectum_core::{Overlay, Tables};
use tectum_optics::OutputMap;

use super::Attitudes;

/// From line to line of scales, degrees, where nothing else is said.
const USUAL_STEP_DEG: f64 = 30.0;

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

    /// Draws on a frame that came `since_ns` after the first, rows tightly packed. Without
    /// `has_time`, that counts frames.
    pub fn draw(
        &self,
        (since_ns, has_time): (i64, bool),
        format: Format,
        picture: &mut [u8],
    ) -> anyhow::Result<()> {
        match self {
            Self::Body(overlay) => draw_overlay(overlay, format, picture)?,
            Self::World {
                map,
                step_deg,
                attitudes,
            } => {
                let world_from_body = attitudes.at(attitudes.time_s(since_ns, has_time)?)?;
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
