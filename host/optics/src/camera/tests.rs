//! Properties that every model has: there and back, and a typed refusal outside.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proptest::prelude::*;

use super::*;
use crate::convention::angle_between;
use crate::io::ocam_calib::OcamCalib;

/// A lens, where its field ends by the model's own formula, and where the picture does.
#[derive(Debug, Clone)]
struct Lens {
    model: CameraModel,
    /// Half-angle of the field, rad.
    end_rad: f64,
    /// Radius of the image circle before principal point, focal lengths and affine map; infinite
    /// where the whole plane is picture.
    end_radius: f64,
}

impl Lens {
    /// Pixel at `radius` towards `azimuth` in the plane that `end_radius` lies in.
    fn pixel(&self, radius: f64, azimuth: f64) -> [f64; 2] {
        let (x, y) = (radius * azimuth.cos(), radius * azimuth.sin());
        let [cx, cy] = self.model.principal_point_px();
        let scaled = |focal: [f64; 2]| [cx + focal[0] * x, cy + focal[1] * y];
        match &self.model {
            CameraModel::Ocam(m) => {
                let ideal = nalgebra::Vector2::new(x, y);
                let shifted = ideal + Ocam::decentring_px(m.decentring_per_px(), ideal);
                let ([c, d, e], x, y) = (m.affine, shifted.x, shifted.y);
                [x + e * y + cx, d * x + c * y + cy]
            }
            CameraModel::KannalaBrandt(m) => scaled(m.focal_px),
            CameraModel::DoubleSphere(m) => scaled(m.focal_px),
            CameraModel::Eucm(m) => scaled(m.focal_px),
            CameraModel::Equidistant(m) => scaled([m.focal_px_per_rad; 2]),
        }
    }
}

fn ray(angle: f64, azimuth: f64) -> Vector3<f64> {
    Vector3::new(
        angle.sin() * azimuth.cos(),
        angle.sin() * azimuth.sin(),
        angle.cos(),
    )
}

fn centre() -> impl Strategy<Value = [f64; 2]> {
    prop::array::uniform2(-50.0..2000.0)
}

fn focal() -> impl Strategy<Value = [f64; 2]> {
    (100.0..900.0, 0.9..1.1).prop_map(|(f, ratio): (f64, f64)| [f, f * ratio])
}

fn equidistant() -> impl Strategy<Value = Lens> {
    (100.0..900.0, centre()).prop_map(|(focal, centre)| Lens {
        model: CameraModel::Equidistant(Equidistant::new(focal, centre).unwrap()),
        end_rad: PI,
        end_radius: PI,
    })
}

/// Coefficients about as large as published ones of 190 to 220 degree lenses.
fn kannala_brandt() -> impl Strategy<Value = Lens> {
    let distortion = (-0.1..0.1, -0.03..0.03, -0.02..0.02, -0.003..0.006);
    (focal(), centre(), distortion).prop_map(|(focal, centre, (k1, k2, k3, k4))| {
        let model = KannalaBrandt::new(focal, centre, [k1, k2, k3, k4]).unwrap();
        let t = model.max_theta_rad();
        let powers = [(k1, 3), (k2, 5), (k3, 7), (k4, 9)];
        let end_radius = powers.iter().fold(t, |sum, (k, n)| sum + k * t.powi(*n));
        Lens {
            model: CameraModel::KannalaBrandt(model),
            end_rad: t,
            end_radius,
        }
    })
}

/// Shapes about that of the published 220 degree lenses, whose scale-free coefficients are
/// 1, 0, -0.50, 0.27, -0.14.
fn ocam() -> impl Strategy<Value = Lens> {
    let shape = (-0.6..-0.3, -0.1..0.3, -0.25..-0.05);
    let affine = (0.95..1.05, -0.05..0.05, -0.05..0.05);
    // Scale-free; the greatest stretch that is allowed is 0.6.
    let decentring = prop::array::uniform2(-8e-3..8e-3);
    (100.0..900.0, shape, centre(), affine, 0.5..3.5, decentring).prop_map(
        |(a0, (s2, s3, s4), centre, (c, d, e), reach, t): (f64, _, _, _, _, [f64; 2])| {
            let polynomial = vec![a0, 0.0, s2 / a0, s3 / a0.powi(2), s4 / a0.powi(3)];
            let model = Ocam::new(polynomial, centre, [c, d, e], reach * a0)
                .and_then(|lens| lens.with_decentring(t.map(|t| t / a0)))
                .unwrap();
            let end_radius = model.max_rho_px();
            Lens {
                end_rad: end_radius.atan2(model.evaluate(end_radius).0),
                model: CameraModel::Ocam(model),
                end_radius,
            }
        },
    )
}

/// Cosine, less its sign, of the angle at which a pinhole's picture of a sphere ends.
fn w(alpha: f64) -> f64 {
    (alpha / (1.0 - alpha)).min((1.0 - alpha) / alpha)
}

fn double_sphere() -> impl Strategy<Value = Lens> {
    (focal(), centre(), -0.95..0.95, 0.0..=1.0).prop_map(
        |(focal, centre, xi, alpha): (_, _, f64, f64)| {
            let model = DoubleSphere::new(focal, centre, xi, alpha).unwrap();
            // The ray at angle phi about the second sphere's centre meets the first one at t.
            let (cos, sin) = (-w(alpha), (1.0 - w(alpha).powi(2)).sqrt());
            let t = xi * cos + (1.0 - (xi * sin).powi(2)).sqrt();
            Lens {
                model: CameraModel::DoubleSphere(model),
                end_rad: (t * sin).atan2(t * cos - xi),
                end_radius: end_radius(alpha, 1.0),
            }
        },
    )
}

fn eucm() -> impl Strategy<Value = Lens> {
    (focal(), centre(), 0.0..=1.0, 0.3..3.0).prop_map(
        |(focal, centre, alpha, beta): (_, _, f64, f64)| {
            let model = Eucm::new(focal, centre, alpha, beta).unwrap();
            // z = -w sqrt(beta r^2 + z^2).
            let w = w(alpha);
            Lens {
                model: CameraModel::Eucm(model),
                end_rad: (1.0 - w * w).sqrt().atan2(-w * beta.sqrt()),
                end_radius: end_radius(alpha, beta),
            }
        },
    )
}

fn end_radius(alpha: f64, beta: f64) -> f64 {
    if alpha > 0.5 {
        1.0 / ((2.0 * alpha - 1.0) * beta).sqrt()
    } else {
        f64::INFINITY
    }
}

fn lens() -> impl Strategy<Value = Lens> {
    prop_oneof![
        equidistant(),
        kannala_brandt(),
        ocam(),
        double_sphere(),
        eucm()
    ]
}

/// 0 to 1, both ends and their surroundings often.
fn fraction() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..=1.0,
        1 => Just(0.0),
        1 => Just(1.0),
        1 => 0.0..1e-9,
        1 => (0.0..1e-6).prop_map(|t: f64| 1.0 - t),
    ]
}

/// How far from its end the field is tried, rad (0.006 degrees). Double sphere and EUCM squeeze the
/// last angles into no pixels at all: the radius has no slope there, and rounding of a pixel is
/// amplified without bound. At 1e-5, one lens in some thousands reaches 1e-9 rad.
const RIM_RAD: f64 = 1e-4;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_480))]

    #[test]
    fn ray_to_pixel_and_back(
        lens in lens(),
        fraction in fraction(),
        azimuth in 0.0..TAU,
        length in prop::sample::select(vec![1e-6, 1.0, 1e9]),
    ) {
        let ray = ray(fraction * (lens.end_rad - RIM_RAD), azimuth);
        let pixel = lens.model.project(&(ray * length)).unwrap();
        let back = lens.model.unproject(pixel).unwrap();
        prop_assert!((back.norm() - 1.0).abs() < 1e-12);
        let error = angle_between(&ray, &back);
        // What is asked of every model.
        prop_assert!(error <= 1e-9, "{error} rad, {pixel:?}");
    }

    #[test]
    fn pixel_to_ray_and_back(lens in lens(), fraction in fraction(), azimuth in 0.0..TAU) {
        // Five focal lengths or so where the picture has no end.
        let wide = if matches!(lens.model, CameraModel::Ocam(_)) { 2000.0 } else { 5.0 };
        let radius = fraction * lens.end_radius.min(wide);
        let pixel = lens.pixel(radius, azimuth);
        match lens.model.unproject(pixel) {
            Ok(ray) => {
                let off_axis = angle_between(&ray, &Vector3::z());
                prop_assert!(off_axis <= lens.end_rad + RIM_RAD, "{off_axis}");
                if off_axis < lens.end_rad - RIM_RAD {
                    let back = lens.model.project(&ray).unwrap();
                    let error = (back[0] - pixel[0]).hypot(back[1] - pixel[1]);
                    // 1e-9 rad at 1000 px to a radian.
                    prop_assert!(error <= 1e-6, "{error} px");
                }
            }
            // Rounding may put the rim itself on either side.
            Err(error) => {
                prop_assert_eq!(error, ModelError::OutsideImage);
                prop_assert!(radius > lens.end_radius * (1.0 - 1e-9));
            }
        }
    }

    #[test]
    fn rays_outside_the_field_are_refused(
        lens in lens(),
        fraction in fraction(),
        azimuth in 0.0..TAU,
    ) {
        let start = (lens.end_rad + 1e-9).min(PI);
        let ray = ray(start + fraction * (PI - start), azimuth);
        // The equidistant lens sees everything but what is straight behind it.
        if !matches!(lens.model, CameraModel::Equidistant(_)) {
            prop_assert_eq!(lens.model.project(&ray), Err(ModelError::OutsideField));
        }
        prop_assert_eq!(lens.model.project(&-Vector3::z()), Err(ModelError::OutsideField));
    }

    #[test]
    fn pixels_outside_the_circle_are_refused(
        lens in lens(),
        factor in 1.000_001..1000.0,
        azimuth in 0.0..TAU,
    ) {
        if lens.end_radius.is_finite() {
            // Outwards from the circle in the picture. Decentring at many times the circle's radius
            // would fold the plane and put a far ideal point into the circle, where a ray is right.
            let edge = lens.pixel(lens.end_radius, azimuth);
            let centre = lens.model.principal_point_px();
            let pixel = [0, 1].map(|k| centre[k] + factor * (edge[k] - centre[k]));
            prop_assert_eq!(lens.model.unproject(pixel), Err(ModelError::OutsideImage));
        }
    }

    #[test]
    fn what_is_no_ray_or_pixel_is_refused(
        lens in lens(),
        place in 0usize..3,
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let mut ray = Vector3::new(0.1, 0.2, 0.3);
        ray[place] = bad;
        prop_assert_eq!(lens.model.project(&ray), Err(ModelError::NotARay));
        prop_assert_eq!(lens.model.project(&Vector3::zeros()), Err(ModelError::NotARay));
        let mut pixel = lens.model.principal_point_px();
        pixel[place % 2] = bad;
        prop_assert_eq!(lens.model.unproject(pixel), Err(ModelError::OutsideImage));
    }

    #[test]
    fn nothing_finite_gives_something_that_is_not(
        lens in lens(),
        numbers in prop::array::uniform3(prop::num::f64::ANY),
    ) {
        if let Ok(pixel) = lens.model.project(&Vector3::from(numbers)) {
            prop_assert!(pixel.iter().all(|p| p.is_finite()), "{pixel:?}");
        }
        if let Ok(ray) = lens.model.unproject([numbers[0], numbers[1]]) {
            prop_assert!((ray.norm() - 1.0).abs() < 1e-12, "{ray}");
        }
    }
}

#[test]
fn rims_of_bare_spheres_are_refused_or_rays() {
    // alpha = 1 is an orthographic picture of a sphere: at its rim, 0 / 0 is near.
    let sphere = DoubleSphere::new([1.0; 2], [0.0; 2], 0.0, 1.0).unwrap();
    let ellipsoid = Eucm::new([1.0; 2], [0.0; 2], 1.0, 1.0).unwrap();
    for model in [
        CameraModel::DoubleSphere(sphere),
        CameraModel::Eucm(ellipsoid),
    ] {
        for pixel in [[1.0, 0.0], [0.6, 0.8], [0.0, -1.0]] {
            match model.unproject(pixel) {
                Ok(ray) => assert!((ray.norm() - 1.0).abs() < 1e-12, "{model:?} {ray}"),
                Err(error) => assert_eq!(error, ModelError::OutsideImage),
            }
        }
    }
}

#[test]
fn wide_lenses_go_beyond_90_degrees() {
    let wide = 110f64.to_radians();
    let polynomial = vec![380.0, 0.0, -1.3e-3, 1.8e-6, -2.4e-9];
    let models = [
        CameraModel::Ocam(Ocam::new(polynomial, [0.0; 2], [1.0, 0.0, 0.0], 800.0).unwrap()),
        CameraModel::KannalaBrandt(
            KannalaBrandt::new([350.0; 2], [0.0; 2], [-0.03, 0.015, -0.018, 0.006]).unwrap(),
        ),
        CameraModel::Equidistant(Equidistant::new(350.0, [0.0; 2]).unwrap()),
        CameraModel::DoubleSphere(DoubleSphere::new([313.0; 2], [0.0; 2], -0.18, 0.59).unwrap()),
        CameraModel::Eucm(Eucm::new([380.0; 2], [0.0; 2], 0.62, 1.1).unwrap()),
    ];
    for model in models {
        let mut last = 0.0;
        for step in 1..=1000 {
            let ray = ray(wide * f64::from(step) / 1000.0, 0.7);
            let [x, y] = model.project(&ray).unwrap();
            let radius = x.hypot(y);
            assert!(radius > last, "{model:?} folds back");
            last = radius;
            let back = model.unproject([x, y]).unwrap();
            assert!(angle_between(&ray, &back) <= 1e-9);
        }
        let down = model.project(&ray(1.0, FRAC_PI_2)).unwrap();
        assert!(
            down[1] > 0.0 && down[0].abs() < 1e-9,
            "{model:?}: y is down"
        );
    }
}

#[test]
fn published_lenses_of_220_degrees_go_there_and_back() {
    let Some(folder) = tectum_test_data::data("rig220-sweepnet") else {
        return;
    };
    let (mut worst_rad, mut worst_px) = (0.0f64, 0.0f64);
    for camera in 1..=4 {
        let path = folder.join(format!("ocam{camera}.txt"));
        let calib = OcamCalib::parse(&std::fs::read_to_string(path).unwrap()).unwrap();
        let model = CameraModel::Ocam(calib.to_model(calib.farthest_corner_px()).unwrap());
        for tenth in 0..=1100 {
            for azimuth in 0..36 {
                let angle = (f64::from(tenth) / 10.0).to_radians();
                let ray = ray(angle, (f64::from(azimuth) * 10.0).to_radians());
                let back = model.unproject(model.project(&ray).unwrap()).unwrap();
                worst_rad = worst_rad.max(angle_between(&ray, &back));
            }
        }
        for x in (0..calib.size_px[0]).step_by(7) {
            for y in (0..calib.size_px[1]).step_by(7) {
                let (x, y) = (f64::from(x), f64::from(y));
                let [u, v] = model.project(&model.unproject([x, y]).unwrap()).unwrap();
                worst_px = worst_px.max((u - x).hypot(v - y));
            }
        }
    }
    println!("rig220-sweepnet: {worst_rad:.1e} rad, {worst_px:.1e} px");
    assert!(worst_rad <= 1e-9 && worst_px <= 1e-6);
}

#[test]
fn a_pixel_in_the_circle_has_the_ray_of_the_circle_not_of_a_fold() {
    let lens = Ocam::new(
        vec![100.0, 0.0, -0.003, 0.0, -5e-8],
        [0.0; 2],
        [0.95, 0.0, 0.0],
        350.0,
    )
    .and_then(|lens| lens.with_decentring([3.964e-5, -7.8906e-5]))
    .unwrap();
    // An ideal point at eleven times the circle's radius, which decentring moves into the circle.
    let far = 11.36 * lens.max_rho_px() * nalgebra::Vector2::new(0.8409, -0.5412);
    let shifted = far + Ocam::decentring_px(lens.decentring_per_px(), far);
    assert!(shifted.norm() < 0.8 * lens.max_rho_px(), "{shifted}");
    let pixel = [shifted.x, 0.95 * shifted.y];
    let model = CameraModel::Ocam(lens);
    let back = model.project(&model.unproject(pixel).unwrap()).unwrap();
    // Rounding of a root at hundreds of px.
    assert!(
        (0..2).all(|k| (back[k] - pixel[k]).abs() < 1e-9),
        "{back:?} {pixel:?}"
    );
}
