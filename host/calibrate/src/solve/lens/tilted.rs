//! A polynomial lens before a sensor that is not square to it: the lens that judges the others.

use nalgebra::{Matrix2, Vector2, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::ParameterError;

use super::{Kind, Lens, OcamLens, Projection};

/// Parameters: those of the polynomial lens, then the tilt `t1, t2` in units of its scale: an offset `y`
/// from the centre is seen at `y / (1 + t.y / s)`, as a plane that is tilted sees it.
///
/// No camera model holds the tilt; this lens only shows what those that are held leave out.
#[derive(Debug, Clone, Copy)]
pub struct TiltedLens(OcamLens);

impl TiltedLens {
    /// Before a sensor that may be tilted.
    pub fn new(lens: OcamLens) -> Self {
        Self(lens)
    }

    /// Parameters of the lens and tilt, 1/px.
    fn split<'a>(&self, p: &'a [f64]) -> (&'a [f64], Vector2<f64>) {
        let (lens, tilt) = p.split_at(self.0.count());
        (lens, Vector2::new(tilt[0], tilt[1]) / self.0.scale_px())
    }
}

impl Lens for TiltedLens {
    fn name(&self) -> String {
        format!("{}, tilted", self.0.name())
    }

    fn describe(&self) -> Vec<(String, f64)> {
        let factor = 1.0 / self.0.scale_px();
        let tilt = [0, 1].map(|k| (format!("tilt_per_px[{k}]"), factor));
        self.0.describe().into_iter().chain(tilt).collect()
    }

    fn degree(&self) -> usize {
        self.0.degree()
    }

    fn kind(&self) -> Kind {
        self.0.kind()
    }

    fn count(&self) -> usize {
        self.0.count() + 2
    }

    fn project(&self, p: &[f64], ray: &Vector3<f64>) -> Option<Projection> {
        let (lens, tilt) = self.split(p);
        let mut seen = self.0.project(lens, ray)?;
        let centre = Vector2::new(lens[0], lens[1]);
        let offset = seen.pixel - centre;
        let stretch = 1.0 + tilt.dot(&offset);
        if stretch <= 0.0 {
            return None;
        }
        let tilted = offset / stretch;
        let by_offset = (Matrix2::identity() - tilted * tilt.transpose()) / stretch;
        seen.pixel = centre + tilted;
        seen.by_ray = by_offset * seen.by_ray;
        // The centre moves the offset by nothing.
        for by in &mut seen.by_lens[2..lens.len()] {
            *by = by_offset * *by;
        }
        for k in 0..2 {
            seen.by_lens[lens.len() + k] = -tilted * (offset[k] / stretch / self.0.scale_px());
        }
        Some(seen)
    }

    fn unproject(&self, p: &[f64], pixel: [f64; 2]) -> Option<Vector3<f64>> {
        let (lens, tilt) = self.split(p);
        let tilted = Vector2::new(pixel[0] - lens[0], pixel[1] - lens[1]);
        let stretch = 1.0 - tilt.dot(&tilted);
        if stretch <= 0.0 {
            return None;
        }
        let offset = tilted / stretch;
        let ideal = [lens[0] + offset.x, lens[1] + offset.y];
        self.0.unproject(lens, ideal)
    }

    fn meet_profile(&self, centre_px: [f64; 2], profile: &[[f64; 2]]) -> Option<Vec<f64>> {
        let mut p = self.0.meet_profile(centre_px, profile)?;
        p.extend([0.0; 2]);
        Some(p)
    }

    fn camera(&self, p: &[f64], radius_px: f64) -> Result<CameraModel, ParameterError> {
        self.0.camera(self.split(p).0, radius_px)
    }
}
