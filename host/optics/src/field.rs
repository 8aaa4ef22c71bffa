//! What an eye really shows: the lens's image circle and the sensor's rectangle.

use nalgebra::Vector3;

use crate::camera::{CameraModel, ModelError};
use crate::convention::angle_between;

/// Greatest half-angle that can be asked for, rad: just under straight back.
const MAX_HALF_ANGLE_RAD: f64 = 179.0 * std::f64::consts::PI / 180.0;

/// Half-angle of the lens's field as a function of the image direction, rad.
///
/// Sample i of n belongs to the azimuth `2 pi i / n` in the camera frame, from +x (right) towards
/// +y (down); between samples the half-angle is linear. One sample is a full circle.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    half_angles_rad: Vec<f64>,
    /// Cosine of an angle off the axis above which every azimuth is inside, and below which every
    /// one is outside: most rays need no angle.
    surely_inside: f64,
    surely_outside: f64,
}

/// Of the cosines in [`Field`]: far above the rounding of an angle and its cosine, 1e-15.
const COSINE_MARGIN: f64 = 1e-9;

/// A half-angle that is not between 0 and 179 degrees, or none at all.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a half-angle of the field must be between 0 and 179 degrees, at least one is needed")]
pub struct FieldError;

impl Field {
    /// A field from half-angles around the image, rad.
    ///
    /// # Errors
    /// [`FieldError`] if there is none, or one out of range.
    pub fn new(half_angles_rad: Vec<f64>) -> Result<Self, FieldError> {
        let sound = |angle: &f64| *angle > 0.0 && *angle <= MAX_HALF_ANGLE_RAD;
        if half_angles_rad.is_empty() || !half_angles_rad.iter().all(sound) {
            return Err(FieldError);
        }
        let narrowest_rad = half_angles_rad
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let widest_rad = half_angles_rad.iter().copied().fold(0.0, f64::max);
        Ok(Self {
            half_angles_rad,
            surely_inside: libm::cos(narrowest_rad) + COSINE_MARGIN,
            surely_outside: libm::cos(widest_rad) - COSINE_MARGIN,
        })
    }

    /// The samples, rad.
    pub fn half_angles_rad(&self) -> &[f64] {
        &self.half_angles_rad
    }

    /// Half-angle in the direction of `azimuth_rad`.
    pub fn half_angle_rad(&self, azimuth_rad: f64) -> f64 {
        let n = self.half_angles_rad.len();
        let turns = azimuth_rad / std::f64::consts::TAU;
        let place = (turns - libm::floor(turns)) * n as f64;
        let first = (place as usize).min(n - 1);
        let t = place - first as f64;
        (1.0 - t) * self.half_angles_rad[first] + t * self.half_angles_rad[(first + 1) % n]
    }

    /// The half-angle of a field of one sample, a full circle, rad.
    pub fn circle_rad(&self) -> Option<f64> {
        match self.half_angles_rad[..] {
            [half] => Some(half),
            _ => None,
        }
    }

    /// The greatest half-angle over all directions, rad.
    pub fn widest_rad(&self) -> f64 {
        self.half_angles_rad.iter().copied().fold(0.0, f64::max)
    }
}

/// Why an eye does not show a ray, or a pixel has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SightError {
    /// The camera model has no answer.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Outside the lens's field.
    #[error("outside the field of the lens")]
    OutsideField,
    /// Inside the lens's field, but off the sensor.
    #[error("off the sensor")]
    OffSensor,
    /// The distance asked for is not beyond the eye's own distance from the body's origin.
    #[error("the distance is not beyond the eye itself")]
    TooNear,
}

/// One eye: a camera model, the field of its lens, the size of its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Eye {
    /// Width and height of the frame, px.
    pub size_px: [u16; 2],
    /// Ray to pixel.
    pub model: CameraModel,
    /// What the lens shows.
    pub field: Field,
}

impl Eye {
    /// Pixel of a camera-frame ray of any length. The sensor covers -0.5 to size - 0.5.
    ///
    /// # Errors
    /// [`SightError`] if the eye does not show it.
    pub fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], SightError> {
        self.check_field(ray)?;
        let pixel = self.model.project(ray)?;
        self.check_sensor(pixel)?;
        Ok(pixel)
    }

    /// Unit ray in the camera frame through a pixel.
    ///
    /// # Errors
    /// [`SightError`] if the eye shows nothing there.
    pub fn unproject(&self, pixel: [f64; 2]) -> Result<Vector3<f64>, SightError> {
        self.check_sensor(pixel)?;
        let ray = self.model.unproject(pixel)?;
        self.check_field(&ray)?;
        Ok(ray)
    }

    /// Half-angle in the direction of `azimuth_rad` that lens **and sensor** show: the field's,
    /// or where the sensor's border clips it. Found to 1e-9 rad, in rad.
    pub fn half_angle_rad(&self, azimuth_rad: f64) -> f64 {
        let seen = |theta: f64| {
            let pixel = self.model.project(&ray_at(theta, azimuth_rad));
            pixel.is_ok_and(|px| self.check_sensor(px).is_ok())
        };
        let field = self.field.half_angle_rad(azimuth_rad);
        if seen(field) {
            return field;
        }
        last_true(seen, field, 1e-9)
    }

    /// The half-angle at which the camera model ends **on the sensor**, inside the field that the
    /// eye claims, if there is one: such an eye would be blind where it says it sees. Looks in 64
    /// directions.
    pub fn model_gap_rad(&self) -> Option<f64> {
        const DIRECTIONS: u32 = 64;
        let azimuths =
            (0..DIRECTIONS).map(|i| f64::from(i) / f64::from(DIRECTIONS) * std::f64::consts::TAU);
        azimuths
            .filter_map(|azimuth_rad| {
                let claimed = self.field.half_angle_rad(azimuth_rad);
                let reached = self.model_end_rad(azimuth_rad, claimed)?;
                let edge = self.model.project(&ray_at(reached, azimuth_rad)).ok()?;
                self.check_sensor(edge).is_ok().then_some(reached)
            })
            .reduce(f64::min)
    }

    /// Where the model ends in a direction, to 1e-6 rad; `None` if it reaches `claimed_rad`.
    fn model_end_rad(&self, azimuth_rad: f64, claimed_rad: f64) -> Option<f64> {
        let answers = |theta: f64| self.model.project(&ray_at(theta, azimuth_rad)).is_ok();
        if answers(claimed_rad) {
            return None;
        }
        Some(last_true(answers, claimed_rad, 1e-6))
    }

    fn check_field(&self, ray: &Vector3<f64>) -> Result<(), SightError> {
        if !ray.iter().all(|v| v.is_finite()) {
            return Err(ModelError::NotARay.into());
        }
        let length = ray.norm();
        // The square of any other length may be 0 or infinite.
        if (1e-100..1e100).contains(&length) {
            if ray.z > length * self.field.surely_inside {
                return Ok(());
            }
            if ray.z < length * self.field.surely_outside {
                return Err(SightError::OutsideField);
            }
        }
        let off_axis = angle_between(ray, &Vector3::z());
        let azimuth = libm::atan2(ray.y, ray.x);
        if off_axis > self.field.half_angle_rad(azimuth) {
            return Err(SightError::OutsideField);
        }
        Ok(())
    }

    fn check_sensor(&self, pixel: [f64; 2]) -> Result<(), SightError> {
        let inside = |p: f64, side: u16| (-0.5..f64::from(side) - 0.5).contains(&p);
        if inside(pixel[0], self.size_px[0]) && inside(pixel[1], self.size_px[1]) {
            Ok(())
        } else {
            Err(SightError::OffSensor)
        }
    }
}

/// Where `f`, true at 0 and false at `end`, turns false: by bisection, to `tolerance`, from below.
fn last_true(f: impl Fn(f64) -> bool, end: f64, tolerance: f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    while high - low > tolerance {
        let middle = (low + high) / 2.0;
        if f(middle) {
            low = middle
        } else {
            high = middle
        }
    }
    low
}

/// Unit ray `theta_rad` off the axis in the direction of `azimuth_rad`.
fn ray_at(theta_rad: f64, azimuth_rad: f64) -> Vector3<f64> {
    let sin = libm::sin(theta_rad);
    Vector3::new(
        sin * libm::cos(azimuth_rad),
        sin * libm::sin(azimuth_rad),
        libm::cos(theta_rad),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Equidistant;

    fn eye(size_px: [u16; 2]) -> Eye {
        let centre = size_px.map(|side| f64::from(side - 1) / 2.0);
        Eye {
            size_px,
            model: CameraModel::Equidistant(Equidistant::new(100.0, centre).unwrap()),
            field: Field::new(vec![105f64.to_radians()]).unwrap(),
        }
    }

    #[test]
    fn the_sensor_clips_the_circle() {
        // The circle's radius is 183.3 px: 400 px wide hold it, 300 px high do not.
        let eye = eye([400, 300]);
        assert_eq!(eye.half_angle_rad(0.0), 105f64.to_radians());
        // 150 px at 100 px to a radian, less the half-open border.
        assert!((eye.half_angle_rad(std::f64::consts::FRAC_PI_2) - 1.5).abs() < 1e-8);
        let down = Vector3::new(0.0, libm::sin(1.6), libm::cos(1.6));
        assert_eq!(eye.project(&down), Err(SightError::OffSensor));
        let right = Vector3::new(libm::sin(1.9), 0.0, libm::cos(1.9));
        assert_eq!(eye.project(&right), Err(SightError::OutsideField));
    }

    /// Near the border, too, where the angle itself decides, and for rays of any length.
    #[test]
    fn a_ray_is_inside_up_to_the_fields_half_angle() {
        for half_deg in [1e-4, 0.5, 60.0, 90.0, 105.0, 179.0f64] {
            let half = half_deg.to_radians();
            let eye = Eye {
                field: Field::new(vec![half]).unwrap(),
                ..eye([2000, 2000])
            };
            for off in [1e-3, 1e-7, 1e-9, 1e-10, 1e-12].map(|off| off * half.min(0.01)) {
                for length in [1.0, 1e-3, 1e-120, 1e120] {
                    let [inside, outside] =
                        [half - off, half + off].map(|theta| ray_at(theta, 0.3) * length);
                    assert_eq!(eye.check_field(&inside), Ok(()), "{half_deg} {off}");
                    let outside = eye.check_field(&outside);
                    assert_eq!(outside, Err(SightError::OutsideField), "{half_deg} {off}");
                }
            }
        }
    }

    #[test]
    fn half_angles_are_linear_between_samples() {
        let field = Field::new(vec![1.0, 2.0, 1.0, 2.0]).unwrap();
        let quarter = std::f64::consts::FRAC_PI_4;
        assert!((field.half_angle_rad(quarter) - 1.5).abs() < 1e-12);
        assert!((field.half_angle_rad(-quarter) - 1.5).abs() < 1e-12);
        assert_eq!(Field::new(vec![]), Err(FieldError));
        assert_eq!(Field::new(vec![f64::NAN]), Err(FieldError));
    }
}
