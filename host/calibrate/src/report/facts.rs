//! What several sections draw on, worked out once.

use nalgebra::Vector3;
use tectum_optics::convention::angle_between;
use tectum_optics::{Eye, Field};

use super::coverage::{Coverage, Place, Shown, coverage};
use super::verdict::{Grounds, Verdict};
use super::{ReportInput, ReportView, image_circle, precision};
use crate::{CornerFit, ModelScore, ViewFit};

/// Straight back is no field of a lens, rad.
const WIDEST_RAD: f64 = 179.0 * std::f64::consts::PI / 180.0;

/// Where the edge of the field comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldSource {
    Stated,
    DarkRim,
    Sensor,
}

/// A corner of a view beside its fit.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    pub seen_px: [f64; 2],
    pub fit: CornerFit,
    /// `None` outside the model.
    pub off_axis_rad: Option<f64>,
}

impl Sighting {
    /// Length of the residual, px.
    pub fn length_px(&self) -> f64 {
        libm::hypot(self.fit.residual_px[0], self.fit.residual_px[1])
    }
}

/// A picture with its part in the calibration.
#[derive(Debug)]
pub struct Picture<'a> {
    pub given: &'a ReportView<'a>,
    /// `None` if the calibration holds fewer views than were given.
    pub fit: Option<&'a ViewFit>,
    pub place: Option<Place>,
    /// Corners with a fit that is finite.
    pub sightings: Vec<Sighting>,
}

impl Picture<'_> {
    /// Whether it took part.
    pub fn accepted(&self) -> bool {
        self.fit.is_some_and(|fit| fit.rejection.is_none())
    }

    /// Corners that took part.
    pub fn used(&self) -> impl Iterator<Item = &Sighting> {
        let accepted = self.accepted();
        self.sightings
            .iter()
            .filter(move |s| s.fit.used && accepted)
    }
}

/// What the sections draw on.
#[derive(Debug)]
pub struct Facts<'a> {
    pub input: &'a ReportInput<'a>,
    pub pictures: Vec<Picture<'a>>,
    pub eye: Eye,
    pub field_source: FieldSource,
    pub coverage: Coverage,
    pub verdict: Verdict,
}

impl<'a> Facts<'a> {
    pub fn new(input: &'a ReportInput<'a>) -> Self {
        let calibration = input.calibration;
        let (half_field, field_source) = half_field_rad(input);
        let side = |px: u32| u16::try_from(px).unwrap_or(u16::MAX);
        let field = Field::new(vec![half_field]).or_else(|_| Field::new(vec![WIDEST_RAD]));
        let eye = Eye {
            size_px: calibration.size_px.map(side),
            model: calibration.model.clone(),
            field: field.expect("the widest field is one"),
        };
        let fits = calibration
            .views
            .iter()
            .map(Some)
            .chain(std::iter::repeat(None));
        let pictures: Vec<Picture> = input
            .views
            .iter()
            .zip(fits)
            .map(|(given, fit)| picture(input, given, fit))
            .collect();
        let shown: Vec<Shown> = pictures
            .iter()
            .filter(|picture| picture.accepted())
            .map(|picture| Shown {
                corners_px: picture.used().map(|s| s.seen_px).collect(),
                place: picture.place,
            })
            .collect();
        let coverage = coverage(&eye, &shown);
        let limit_rad = coverage.limit_rad.iter().copied().fold(0.0, f64::max);
        let sigma_rad = input.rotation_free_sigma_rad;
        let sigma_rad = sigma_rad.unwrap_or(input.angular_sigma_rad);
        let verdict = Verdict::new(&Grounds {
            calibration,
            coverage: &coverage,
            rings: precision::rings(&eye, limit_rad, sigma_rad),
            corners_seen: input.views.iter().map(|v| v.view.corners.len()).sum(),
        });
        Self {
            input,
            pictures,
            eye,
            field_source,
            coverage,
            verdict,
        }
    }

    /// Corners that took part.
    pub fn used(&self) -> impl Iterator<Item = &Sighting> {
        self.pictures.iter().flat_map(Picture::used)
    }

    /// Corners with a fit that took no part.
    pub fn unused(&self) -> impl Iterator<Item = &Sighting> {
        let all = self.pictures.iter().filter(|picture| picture.accepted());
        all.flat_map(|p| &p.sightings).filter(|s| !s.fit.used)
    }

    /// The score of the calibration's own model.
    pub fn chosen(&self) -> Option<&'a ModelScore> {
        self.input
            .calibration
            .scores
            .iter()
            .find(|score| score.chosen)
    }

    /// Name of the model chosen.
    pub fn model_name(&self) -> &'a str {
        let name = self.chosen().map(|score| score.name.as_str());
        name.unwrap_or(self.input.calibration.model.name())
    }
}

fn half_field_rad(input: &ReportInput) -> (f64, FieldSource) {
    let sound = |angle: &f64| *angle > 0.0 && *angle <= WIDEST_RAD;
    if let Some(stated) = input.half_field_rad.filter(sound) {
        return (stated, FieldSource::Stated);
    }
    let pictures = input.views.iter().filter_map(|view| view.picture);
    let measured = image_circle::half_field_rad(&input.calibration.model, pictures).filter(sound);
    // A rim inside the corners is none; a degree is more than it can be wrong by.
    let least = input.calibration.field_rad - 1f64.to_radians();
    match measured.filter(|measured| *measured > least) {
        Some(measured) => (measured, FieldSource::DarkRim),
        None => (WIDEST_RAD, FieldSource::Sensor),
    }
}

fn picture<'a>(
    input: &ReportInput,
    given: &'a ReportView<'a>,
    fit: Option<&'a ViewFit>,
) -> Picture<'a> {
    let pose = fit.and_then(|fit| fit.pose);
    let place = pose.and_then(|pose| Place::new(&pose, &input.board, given.view));
    let fits = fit.map_or(&[][..], |fit| &fit.corners);
    let sightings = given
        .view
        .corners
        .iter()
        .zip(fits)
        .filter_map(|(corner, fit)| {
            let ray = input.calibration.model.unproject(corner.position_px).ok();
            let numbers = [fit.residual_px, corner.position_px];
            let finite = numbers.as_flattened().iter().all(|v| v.is_finite());
            finite.then(|| Sighting {
                seen_px: corner.position_px,
                fit: *fit,
                off_axis_rad: ray.map(|ray| angle_between(&ray, &Vector3::z())),
            })
        });
    Picture {
        given,
        fit,
        place,
        sightings: sightings.collect(),
    }
}
