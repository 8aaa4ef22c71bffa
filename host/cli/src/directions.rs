//! Which direction a pixel shows, and which pixel shows a direction, as the core says: one answer for
//! the command line and for the preview.

use anyhow::{Context, bail};
use serde_json::{Value, json};
use tectum_core::{BinaryAngle, Direction, Eye, Lookup, Tables};
use tectum_tables::RunKind;

use crate::shown::run_at;

/// What is known about a pixel or a direction.
pub struct Answer {
    /// Place in the stitched picture, px; `None` outside.
    pub place_px: Option<[f64; 2]>,
    /// Yaw, degrees, positive to the left.
    pub yaw_deg: f32,
    /// Pitch, degrees, up is negative.
    pub pitch_deg: f32,
    /// Eye that the stitched picture shows there.
    pub eye: Option<&'static str>,
    /// Places in the raw pictures of the left and the right eye, px; `None` where unseen.
    pub raw_px: [Option<[f64; 2]>; 2],
}

impl Answer {
    /// Of the stitched picture's pixel `at`, or of the raw pixel `at` of an eye.
    pub fn of_pixel(tables: &Tables<'_>, eye: Option<Eye>, at: [f64; 2]) -> anyhow::Result<Self> {
        let lookup = Lookup::new(tables);
        if let Some(eye) = eye {
            let direction = eye_direction(tables, &lookup, eye, at)?;
            let pixel_q8 = lookup.pixel_of_direction(direction);
            return Ok(Self::new(tables, pixel_q8, direction));
        }
        let pixel_q8 = q8(at);
        let direction = lookup.direction_of_pixel(pixel_q8).with_context(|| {
            format!(
                "pixel {},{} shows no direction: the picture is {}x{} px",
                at[0],
                at[1],
                tables.output_width_px(),
                tables.output_height_px()
            )
        })?;
        Ok(Self::new(tables, Some(pixel_q8), direction))
    }

    /// Of a direction, degrees.
    pub fn of_direction(tables: &Tables<'_>, yaw_deg: f64, pitch_deg: f64) -> Self {
        let direction = Direction {
            yaw: BinaryAngle::from_degrees(yaw_deg as f32),
            pitch: BinaryAngle::from_degrees(pitch_deg as f32),
        };
        let pixel_q8 = Lookup::new(tables).pixel_of_direction(direction);
        Self::new(tables, pixel_q8, direction)
    }

    fn new(tables: &Tables<'_>, pixel_q8: Option<[i32; 2]>, direction: Direction) -> Self {
        let px = |q8: [i32; 2]| q8.map(|p| f64::from(p) / 256.0);
        let lookup = Lookup::new(tables);
        let raw = |eye| lookup.eye_pixel_of_direction(eye, direction).map(px);
        Self {
            place_px: pixel_q8.map(px),
            yaw_deg: direction.yaw.degrees(),
            pitch_deg: direction.pitch.degrees(),
            eye: pixel_q8.and_then(|q8| owner(tables, px(q8))),
            raw_px: Eye::BOTH.map(raw),
        }
    }

    /// For a script.
    pub fn json(&self) -> Value {
        let [left, right] = self
            .raw_px
            .map(|raw| raw.map(|[x, y]| json!({ "x": x, "y": y })));
        json!({
            "x": self.place_px.map(|p| p[0]),
            "y": self.place_px.map(|p| p[1]),
            "yaw_deg": self.yaw_deg,
            "pitch_deg": self.pitch_deg,
            "eye": self.eye,
            "left": left,
            "right": right,
        })
    }
}

fn q8(position: [f64; 2]) -> [i32; 2] {
    position.map(|p| (p * 256.0).round() as i32)
}

fn eye_direction(
    tables: &Tables<'_>,
    lookup: &Lookup<'_>,
    eye: Eye,
    at: [f64; 2],
) -> anyhow::Result<Direction> {
    let [width, height] = tables
        .source_size_px(eye)
        .with_context(|| format!("the table does not show the {eye:?} eye"))?;
    let inside = |p: f64, side: u16| (-0.5..f64::from(side) - 0.5).contains(&p);
    if !inside(at[0], width) || !inside(at[1], height) {
        bail!(
            "pixel {},{} is outside the {eye:?} eye's picture of {width}x{height} px",
            at[0],
            at[1]
        );
    }
    lookup.direction_of_eye_pixel(eye, q8(at)).with_context(|| {
        format!(
            "pixel {},{} is outside the {eye:?} eye's field",
            at[0], at[1]
        )
    })
}

/// Who the stitched picture shows at a position; `None` for nobody.
fn owner(tables: &Tables<'_>, position: [f64; 2]) -> Option<&'static str> {
    match run_at(tables, position)? {
        RunKind::Void => None,
        RunKind::Left => Some("left"),
        RunKind::Right => Some("right"),
        RunKind::Blend(_) => Some("both"),
    }
}
