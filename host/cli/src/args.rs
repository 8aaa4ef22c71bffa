//! Arguments that several verbs share.

use std::str::FromStr;

use clap::ValueEnum;
use nalgebra::Rotation3;
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

/// Parser of a finite angle within a turn, degrees.
pub fn degrees(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|deg: &f64| deg.abs() <= 360.0)
        .ok_or_else(|| "needed is an angle in degrees, -360 to 360".into())
}

/// Parser of a time that is not negative, in the unit that the option names.
pub fn duration(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|time: &f64| time.is_finite() && *time >= 0.0)
        .ok_or_else(|| "needed is a number that is not negative".into())
}

/// What the stitched picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProjectionName {
    /// Yaw and pitch on straight axes, body frame, 360 x 180 degrees
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
    /// Yaw of the view's axis, degrees, positive to the left (fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    pub yaw: Option<f64>,
    /// Pitch of the view's axis, degrees, up is negative (fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    pub pitch: Option<f64>,
    /// Roll about the view's axis, degrees, clockwise (fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    pub roll: Option<f64>,
    /// Field of view, degrees (cylindrical, fisheye, perspective)
    #[arg(long, value_name = "DEG", value_parser = degrees)]
    pub fov: Option<f64>,
}

impl OutputArgs {
    /// The output map for a rig.
    pub fn output_map(&self, rig: &Rig) -> anyhow::Result<OutputMap> {
        use ProjectionName as P;
        let has_axis = matches!(self.projection, P::Fisheye | P::Perspective);
        let has_field = has_axis || self.projection == P::Cylindrical;
        let axis_given = self.yaw.or(self.pitch).or(self.roll).is_some();
        if axis_given && !has_axis || self.fov.is_some() && !has_field {
            return Err(Usage(
                "--yaw, --pitch and --roll go with --projection fisheye or perspective, --fov \
                 with these and cylindrical"
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
        Ok(projection.output_map(self.size.0)?)
    }

    fn body_from_view(&self) -> Rotation3<f64> {
        let [yaw, pitch, roll] =
            [self.yaw, self.pitch, self.roll].map(|deg| deg.unwrap_or(0.0).to_radians());
        // A camera looks along its z, a view along its x: an unturned camera is the difference.
        Pose::axis_rotation(yaw, pitch, roll) * Pose::axis_rotation(0.0, 0.0, 0.0).inverse()
    }
}
