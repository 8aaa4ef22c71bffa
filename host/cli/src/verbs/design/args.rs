//! What `tectum design` is asked.

use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;
use nalgebra::Vector3;
use tectum_optics::design::{Goal, Objective, Port, Relation, Span, Want};
use tectum_optics::{FrontElement, FrontElementError};

use crate::args::Position;

/// From a mount to what it sees, from what should be seen to a mount, and fields measured in a tank
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum design --psi 25.7 --tau 29.15 --theta 210                what this mount sees\n  \
    tectum design --psi 25.7 --tau 29.15 --theta 210 --sensor 5:4 --medium bare --pictures seen\n  \
    tectum design --rig rig.toml --plane 30 --plane-normal 1,0,0    a rig, and two more planes\n  \
    tectum design --normal 0.19,0.85,0.49 --eye eye.toml            the hull's normal at the eye\n  \
    tectum design --theta 210 --want front=40 --want zeta=30..60    mounts for a wish\n  \
    tectum design --psi 20..40 --tau 20..35 --theta 180..220 --medium bare --margin 2 \\\n  \
    \u{20}             --want front=10.. --best sphere-seen              a hull, lenses, water\n  \
    tectum design --psi 25.7 --tau 29.15 --theta 210 --wall-distance-mm 300 \\\n  \
    \u{20}             --wall-horizontal-mm 302 --wall-design-mm 755     a field measured in a tank\n\n\
    psi is the angle between the horizontal axes of both cameras: each axis turns psi/2 from straight\n\
    out towards the nose, then tilts up by tau. theta is the whole field of a lens in air. Wishes:\n\
    zeta (elevation of the design plane), xi, phi (overlap on the design plane), total (field on the\n\
    design plane), front (overlap ahead, horizontal), outer (reach, horizontal), in degrees; seen and\n\
    both, as shares of the sphere. A wish of A.. is at least A, ..B at most B.")]
pub struct Args {
    /// psi, degrees; a wish may leave a range: LOW..HIGH (then 0..90 if not given)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with_all = ["normal", "rig"])]
    pub psi: Option<Range>,
    /// tau, degrees, up is positive; a wish may leave a range (then 0..60 if not given)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with_all = ["normal", "rig"])]
    pub tau: Option<Range>,
    /// Whole field of a lens in air, degrees; a wish may leave a range
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with_all = ["eye", "rig"])]
    pub theta: Option<Range>,
    /// The hull's outward normal where the left eye sits (x forward, y left, z up), for psi and tau
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        conflicts_with = "rig"
    )]
    pub normal: Option<Triple>,
    /// Sides of a sensor that is as wide as the image circle and clips it above and below
    #[arg(long, value_name = "W:H", requires = "theta")]
    pub sensor: Option<Sensor>,
    /// Calibrated eye, the same on both sides, for the field: eye file, or a calibration of OCamCalib, Kalibr,
    /// OpenCV or Basalt with one camera
    #[arg(long, value_name = "EYE.toml", conflicts_with = "rig")]
    pub eye: Option<PathBuf>,
    /// Rig, for both fields and where they look: rig file, or a calibration of Kalibr, OpenCV or Basalt with two cameras
    #[arg(long, value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,
    /// What a wish, and pictures, are for
    #[arg(long, value_enum, default_value_t = MediumName::Air)]
    pub medium: MediumName,
    /// Front of a bare lens, 0 (dome) to 1 (flat port); 0.694 fits the paper's horizontal field
    #[arg(long, default_value_t = 0.694, allow_negative_numbers = true)]
    pub kappa: f64,
    /// One more plane, through the left-right axis, its front half this much above the horizon
    #[arg(long, value_name = "DEG", value_parser = crate::args::degrees, allow_negative_numbers = true)]
    pub plane: Vec<f64>,
    /// One more plane, any, by its normal
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub plane_normal: Vec<Triple>,
    /// Folder for pictures, SVG and PNG: map, sphere, mount, each plane
    #[arg(long, value_name = "FOLDER")]
    pub pictures: Option<PathBuf>,
    #[command(flatten)]
    pub wish: WishArgs,
    #[command(flatten)]
    pub measured: MeasuredArgs,
}

/// The other way round.
#[derive(clap::Args)]
#[command(next_help_heading = "From a wish to mounts")]
pub struct WishArgs {
    /// What is wanted: FIGURE=VALUE, FIGURE=LOW.., FIGURE=..HIGH or FIGURE=LOW..HIGH
    #[arg(long, value_name = "WISH", conflicts_with_all = ["eye", "rig", "sensor"])]
    pub want: Vec<WantText>,
    /// What is to be as great as can be; total-field is the paper's max 2 theta - phi
    #[arg(long, value_enum, conflicts_with_all = ["eye", "rig", "sensor"])]
    pub best: Option<ObjectiveName>,
    /// What each half-angle may lose with the wish still fulfilled, degrees
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub margin: Option<f64>,
    /// How many mounts to name
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub count: u16,
}

impl WishArgs {
    /// Whether mounts are looked for.
    pub fn given(&self) -> bool {
        !self.want.is_empty() || self.best.is_some()
    }
}

/// What was measured in a tank.
#[derive(clap::Args)]
#[command(next_help_heading = "A field measured in a tank")]
pub struct MeasuredArgs {
    /// From the fish to the wall behind it
    #[arg(long, value_name = "MM", allow_negative_numbers = true, conflicts_with_all = ["want", "best"])]
    pub wall_distance_mm: Option<f64>,
    /// Between the points on the wall at both pictures' edges, horizontal plane
    #[arg(
        long,
        value_name = "MM",
        requires = "wall_distance_mm",
        allow_negative_numbers = true
    )]
    pub wall_horizontal_mm: Option<f64>,
    /// The same, design plane
    #[arg(
        long,
        value_name = "MM",
        requires = "wall_distance_mm",
        allow_negative_numbers = true
    )]
    pub wall_design_mm: Option<f64>,
    /// Edge pixel of the left eye
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["rig", "edge_right"])]
    pub edge_left: Option<Position>,
    /// Edge pixel of the right eye
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["rig", "edge_left"])]
    pub edge_right: Option<Position>,
}

/// What lies between lens and world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MediumName {
    /// Air
    Air,
    /// Water behind a flat window
    FlatPort,
    /// Water around a dome about the lens's entrance pupil
    Dome,
    /// Water on the lens itself, with --kappa
    Bare,
}

impl MediumName {
    /// The port; none in air.
    pub fn port(self, kappa: f64) -> Result<Option<Port>, FrontElementError> {
        Ok(match self {
            Self::Air => None,
            Self::FlatPort => Some(Port::Flat),
            Self::Dome => Some(Port::Dome),
            Self::Bare => Some(Port::Bare(FrontElement::new(kappa)?)),
        })
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::FlatPort => "water, flat port",
            Self::Dome => "water, dome",
            Self::Bare => "water, bare lens",
        }
    }
}

/// What is to be as great as can be.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ObjectiveName {
    /// The field on the design plane: the paper's max 2 theta - phi
    TotalField,
    /// The share of the sphere that is seen
    SphereSeen,
    /// The share of the sphere that both eyes see
    SphereBoth,
    /// What a lens may lose before the horizontal view ahead has a gap
    Margin,
}

impl From<ObjectiveName> for Objective {
    fn from(name: ObjectiveName) -> Self {
        match name {
            ObjectiveName::TotalField => Self::TotalField,
            ObjectiveName::SphereSeen => Self::SphereSeen,
            ObjectiveName::SphereBoth => Self::SphereBoth,
            ObjectiveName::Margin => Self::Margin,
        }
    }
}

/// An angle, or a range of angles, degrees.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Least.
    pub low: f64,
    /// Greatest.
    pub high: f64,
}

impl Range {
    /// The angle, if it is one.
    pub fn single(self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }
}

impl From<Range> for Span {
    fn from(range: Range) -> Self {
        Self {
            low_rad: range.low.to_radians(),
            high_rad: range.high.to_radians(),
        }
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| finite(text).filter(|deg| deg.abs() <= 720.0);
        let found = match text.split_once("..") {
            Some((low, high)) => number(low).zip(number(high)),
            None => number(text).map(|deg| (deg, deg)),
        };
        found
            .filter(|(low, high)| low <= high)
            .map(|(low, high)| Self { low, high })
            .ok_or_else(|| "needed is an angle in degrees, or LOW..HIGH such as 20..40".into())
    }
}

/// Three numbers.
#[derive(Debug, Clone, Copy)]
pub struct Triple(pub Vector3<f64>);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
        match numbers.as_deref() {
            Some([x, y, z]) => Ok(Self(Vector3::new(*x, *y, *z))),
            _ => Err("needed is X,Y,Z such as 0.2,0.9,0.4".into()),
        }
    }
}

/// Sides of a sensor.
#[derive(Debug, Clone, Copy)]
pub struct Sensor(pub [f64; 2]);

impl FromStr for Sensor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split_once(':')
            .and_then(|(w, h)| Some(Self([finite(w)?, finite(h)?])))
            .ok_or_else(|| "needed is WIDTH:HEIGHT such as 4:3 or 1280:1024".into())
    }
}

/// A wish: one or two limits of one figure.
#[derive(Debug, Clone)]
pub struct WantText(pub Vec<Want>);

impl FromStr for WantText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = Goal::ALL.map(Goal::name).join(", ");
        let wrong = || {
            format!(
                "needed is FIGURE=VALUE such as front=40, zeta=..60 or total=300.., the figure one of \
                 {names}"
            )
        };
        let (name, value) = text.split_once('=').ok_or_else(wrong)?;
        let goal = Goal::ALL.into_iter().find(|goal| goal.name() == name);
        let goal = goal.ok_or_else(wrong)?;
        let want = |relation, text: &str| {
            let value = finite(text).ok_or_else(wrong)?;
            let value = if goal.is_share() {
                value
            } else {
                value.to_radians()
            };
            Ok::<_, String>(Want {
                goal,
                relation,
                value,
            })
        };
        let Some((low, high)) = value.split_once("..") else {
            return Ok(Self(vec![want(Relation::Equal, value)?]));
        };
        let sides = [(low, Relation::AtLeast), (high, Relation::AtMost)];
        let given = sides
            .into_iter()
            .filter(|(text, _)| !text.trim().is_empty());
        let wants = given
            .map(|(text, relation)| want(relation, text))
            .collect::<Result<Vec<_>, _>>()?;
        if wants.is_empty() {
            Err(wrong())
        } else {
            Ok(Self(wants))
        }
    }
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite())
}
