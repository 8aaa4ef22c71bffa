//! Arguments that several verbs share.

use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::ValueEnum;
use nalgebra::Rotation3;
use tectum_bake::fitted_range;
use tectum_optics::{OutputMap, Pose, Projection, Rig};
use tectum_tables::MAX_OUTPUT_PX;

use crate::report::Usage;

/// Width and height of an output, written `640x320`.
#[derive(Debug, Clone, Copy)]
pub struct Size(pub [u16; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| {
            let px = text.parse().unwrap_or(0);
            (1..=MAX_OUTPUT_PX).contains(&px).then_some(px)
        };
        text.split_once('x')
            .and_then(|(w, h)| Some(Self([side(w)?, side(h)?])))
            .ok_or_else(|| {
                format!("needed is WIDTHxHEIGHT in px, such as 640x320, each 1 to {MAX_OUTPUT_PX}")
            })
    }
}

/// A position in a picture, written `X,Y`, px.
#[derive(Debug, Clone, Copy)]
pub struct Position(pub [f64; 2]);

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Far beyond any picture, and safely inside 32 bits in Q8.
        let px = |text: &str| text.trim().parse().ok().filter(|p: &f64| p.abs() <= 1e6);
        text.split_once(',')
            .and_then(|(x, y)| Some(Self([px(x)?, px(y)?])))
            .ok_or_else(|| "needed is X,Y in px, such as 320,160 or 12.5,7".into())
    }
}

/// A number within `allowed`, both ends included; else what is `needed`.
fn within(text: &str, allowed: RangeInclusive<f64>, needed: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|number| allowed.contains(number))
        .ok_or_else(|| format!("needed is {needed}"))
}

/// Parser of a finite angle within a turn, degrees.
pub fn degrees(text: &str) -> Result<f64, String> {
    within(text, -360.0..=360.0, "an angle in degrees, -360 to 360")
}

/// Parser of a field of view, degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    within(text, 0.1..=360.0, "a field of view in degrees, 0.1 to 360")
}

/// Parser of a time, s.
pub fn seconds(text: &str) -> Result<f64, String> {
    within(text, 0.0..=1e9, "a time in seconds, 0 to 1e9")
}

/// Parser of a time, ms.
pub fn milliseconds(text: &str) -> Result<f64, String> {
    within(text, 0.0..=1e6, "a time in milliseconds, 0 to 1e6")
}

/// An angle or a range of angles, degrees, as `--yaw` and `--pitch` take it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Angles {
    /// Of a view's axis.
    One(f64),
    /// From one border to the other.
    Range([f64; 2]),
}

impl FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once("..") {
            None => degrees(text).map(Self::One),
            Some((from, to)) => Ok(Self::Range([degrees(from)?, degrees(to)?])),
        }
        .map_err(|_| {
            "needed is an angle in degrees, -360 to 360, or a range such as -135..135".into()
        })
    }
}

/// What the stitched picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProjectionName {
    /// Yaw and pitch on straight axes, body frame: 360 x 180 degrees, or the ranges given
    Equirect,
    /// The same about the plane through both optical axes
    Design,
    /// A full turn on a cylinder about the vertical; --fov is its height (default 120)
    Cylindrical,
    /// Equidistant fisheye about any axis; --fov across the smaller side (default 180)
    Fisheye,
    /// Perspective about any axis, a virtual gimbal; --fov across the width (default 90)
    Perspective,
}

/// The stitched picture.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct OutputArgs {
    /// Size of the stitched picture, px
    #[arg(long, value_name = "WxH", default_value = "640x320")]
    pub size: Size,
    /// What the stitched picture shows
    #[arg(long, value_enum, default_value_t = ProjectionName::Equirect)]
    pub projection: ProjectionName,
    /// Yaw, degrees, positive to the left: of the view's axis (fisheye, perspective), or what the
    /// picture shows, such as -135..135 (equirect, design, cylindrical)
    #[arg(long, value_name = "DEG|A..B", allow_hyphen_values = true)]
    pub yaw: Option<Angles>,
    /// Pitch, degrees, up is negative: of the view's axis (fisheye, perspective), or what the
    /// picture shows, such as -80..45 from its top (equirect, design, cylindrical)
    #[arg(long, value_name = "DEG|A..B", allow_hyphen_values = true)]
    pub pitch: Option<Angles>,
    /// Show the part that the eyes see: the ranges of yaw and pitch that show most with at most this
    /// much void (equirect, design, cylindrical) [default: 5]
    #[arg(long, value_name = "PERCENT", num_args = 0..=1, require_equals = true,
        default_missing_value = "5", conflicts_with_all = ["yaw", "pitch"])]
    pub fit: Option<f64>,
    /// Roll about the view's axis, degrees, clockwise (fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    pub roll: Option<f64>,
    /// Field of view, degrees (cylindrical, fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = field_of_view, allow_negative_numbers = true)]
    pub fov: Option<f64>,
}

impl OutputArgs {
    /// The output map for a rig.
    pub fn output_map(&self, rig: &Rig) -> anyhow::Result<OutputMap> {
        use ProjectionName as P;
        let has_axis = matches!(self.projection, P::Fisheye | P::Perspective);
        let has_field = has_axis || self.projection == P::Cylindrical;
        let angles = || [self.yaw, self.pitch].into_iter().flatten();
        let axis_given = angles().any(|a| matches!(a, Angles::One(_))) || self.roll.is_some();
        let range_given = angles().any(|a| matches!(a, Angles::Range(_))) || self.fit.is_some();
        if axis_given && !has_axis || self.fov.is_some() && !has_field {
            return Err(Usage(
                "--yaw, --pitch and --roll of an axis go with --projection fisheye or perspective, \
                 --fov with these and cylindrical. Other pictures take ranges, such as --yaw \
                 -135..135"
                    .into(),
            )
            .into());
        }
        if range_given && has_axis {
            return Err(Usage(
                "--fit and ranges of --yaw and --pitch go with --projection equirect, design or \
                 cylindrical: a fisheye or perspective picture has an axis and --fov"
                    .into(),
            )
            .into());
        }
        let fov_rad = |default: f64| self.fov.unwrap_or(default).to_radians();
        let projection = match self.projection {
            P::Equirect => Projection::Equirect,
            P::Design => rig.design_projection()?,
            P::Cylindrical => Projection::Cylindrical {
                half_height_rad: fov_rad(120.0) / 2.0,
            },
            P::Fisheye => Projection::Fisheye {
                rotation: self.body_from_view(),
                field_rad: fov_rad(180.0),
            },
            P::Perspective => Projection::Perspective {
                rotation: self.body_from_view(),
                width_rad: fov_rad(90.0),
            },
        };
        if let Some(void_percent) = self.fit {
            let range = fitted_range(rig, &projection, void_percent / 100.0)?;
            return Ok(projection.output_map_of_range(self.size.0, &range)?);
        }
        if range_given {
            let mut range = projection.whole_range()?;
            for (given, range) in [
                (self.yaw, &mut range.yaw_rad),
                (self.pitch, &mut range.pitch_rad),
            ] {
                if let Some(Angles::Range(borders)) = given {
                    *range = borders.map(f64::to_radians);
                }
            }
            return Ok(projection.output_map_of_range(self.size.0, &range)?);
        }
        Ok(projection.output_map(self.size.0)?)
    }

    fn body_from_view(&self) -> Rotation3<f64> {
        let one = |angles: Option<Angles>| match angles {
            Some(Angles::One(deg)) => Some(deg),
            _ => None,
        };
        let [yaw, pitch, roll] =
            [one(self.yaw), one(self.pitch), self.roll].map(|deg| deg.unwrap_or(0.0).to_radians());
        // A camera looks along its z, a view along its x: an unturned camera is the difference.
        Pose::axis_rotation(yaw, pitch, roll) * Pose::axis_rotation(0.0, 0.0, 0.0).inverse()
    }
}
