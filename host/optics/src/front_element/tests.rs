use proptest::prelude::*;

use super::*;
use crate::camera::{DoubleSphere, Equidistant, KannalaBrandt};

fn degrees(kappa: f64, air_deg: f64) -> f64 {
    let front = FrontElement::new(kappa).unwrap();
    front.water_rad(air_deg.to_radians()).to_degrees()
}

/// Full angles in water of a lens of 210 degrees, from its two measured fields of view.
#[test]
fn the_papers_fields_of_view() {
    // Three digits of kappa leave 0.05 degrees.
    assert!((2.0 * degrees(0.694, 105.0) - 155.84).abs() < 0.05);
    assert!((2.0 * degrees(0.791, 105.0) - 140.20).abs() < 0.05);
    for (water_deg, kappa) in [(155.84, 0.694), (140.20, 0.791)] {
        let half = f64::to_radians(water_deg / 2.0);
        let front = FrontElement::from_angles(105f64.to_radians(), half).unwrap();
        // Half of the last digit of kappa.
        assert!((front.kappa() - kappa).abs() < 5e-4, "{front:?}");
    }
}

#[test]
fn a_dome_changes_nothing_and_a_flat_port_is_snells_law() {
    assert_eq!(degrees(0.0, 100.0), 100.0);
    let flat = degrees(1.0, 80.0).to_radians();
    // Rounding.
    assert!((WATER_INDEX * flat.sin() - 80f64.to_radians().sin()).abs() < 1e-14);
    let front = FrontElement::new(0.6).unwrap();
    let small = 1e-5;
    // The next term is of order small^2.
    assert!((front.water_rad(small) / small - front.paraxial_ratio()).abs() < 1e-9);
    assert_eq!(
        FrontElement::new(1.0).unwrap().paraxial_ratio(),
        1.0 / WATER_INDEX
    );
}

/// Snell's law in vectors at a surface with this normal (Glassner 1989): nothing of the model's
/// own formula.
fn traced(air: f64, normal: f64) -> f64 {
    let at = |angle: f64| Vector3::new(angle.sin(), 0.0, angle.cos());
    // Light runs inwards; the path is the same outwards.
    let (incoming, normal) = (-at(air), at(normal));
    let ratio = 1.0 / WATER_INDEX;
    let cos = -incoming.dot(&normal);
    let refracted = incoming * ratio
        + normal * (ratio * cos - (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt());
    let outside = -refracted;
    outside.x.atan2(outside.z)
}

proptest! {
    #[test]
    fn the_ray_is_traced_at_the_surface(kappa in 0.0..0.8f64, air in 0.0..1.9f64) {
        let front = FrontElement::new(kappa).unwrap();
        let expected = traced(air, air - kappa * air);
        // Rounding of some ten operations.
        prop_assert!((front.water_rad(air) - expected).abs() < 1e-13);
    }

    #[test]
    fn water_and_air_undo_each_other(kappa in 0.0..=1.0f64, share in 0.0..0.999f64) {
        let front = FrontElement::new(kappa).unwrap();
        let air = share * front.limit_air_rad();
        let again = front.air_rad(front.water_rad(air)).unwrap();
        // Near grazing of a flat port the slope falls to 0.03, so rounding grows.
        prop_assert!((again - air).abs() < 1e-12, "{again} {air}");
    }

    #[test]
    fn kappa_comes_back_from_one_wide_angle(kappa in 0.0..0.85f64) {
        let air = 105f64.to_radians();
        let water = FrontElement::new(kappa).unwrap().water_rad(air);
        let found = FrontElement::from_angles(air, water).unwrap().kappa();
        // Near the axis kappa enters by its first power times (1 - 1 / n): rounding times a few.
        prop_assert!((found - kappa).abs() < 1e-12, "{found}");
    }
}

fn eye(model: CameraModel, half_deg: f64) -> Eye {
    Eye {
        size_px: [1280, 960],
        model,
        field: Field::new(vec![half_deg.to_radians()]).unwrap(),
    }
}

#[test]
fn pixels_keep_their_place_and_rays_turn() {
    let centre = [655.0, 470.0];
    let equidistant = CameraModel::Equidistant(Equidistant::new(250.0, centre).unwrap());
    let kannala = CameraModel::KannalaBrandt(
        KannalaBrandt::new([250.0, 252.0], centre, [-0.01, 0.001, 0.0, 0.0]).unwrap(),
    );
    let double =
        CameraModel::DoubleSphere(DoubleSphere::new([260.0; 2], centre, -0.2, 0.6).unwrap());
    let bent = CameraModel::Ocam(
        Ocam::new(
            vec![250.0, 0.0, -1.2e-3],
            centre,
            [1.002, 1e-3, -2e-3],
            480.0,
        )
        .unwrap(),
    );
    for (model, half_deg) in [
        (equidistant, 105.0),
        (kannala, 95.0),
        (double, 95.0),
        (bent, 90.0),
    ] {
        let front = FrontElement::new(0.694).unwrap();
        let air = eye(model, half_deg);
        let found = front.in_water(&air).unwrap();
        let name = air.model.name();
        assert!(found.misfit_rad < GOOD_RAD, "{name}: {found:?}");
        let mut compared = 0;
        for azimuth_deg in (0..360).step_by(30) {
            for air_deg in [1.0f64, 20.0, 45.0, 70.0, 89.9] {
                let azimuth = f64::from(azimuth_deg).to_radians();
                let ray = |theta: f64| {
                    let (s, c) = azimuth.sin_cos();
                    Vector3::new(theta.sin() * c, theta.sin() * s, theta.cos())
                };
                let Ok(pixel) = air.project(&ray(air_deg.to_radians())) else {
                    continue;
                };
                let water = found.eye.unproject(pixel).unwrap();
                let expected = ray(front.water_rad(air_deg.to_radians()));
                let off = crate::convention::angle_between(&water, &expected);
                // The misfit, and what it may be between samples.
                assert!(
                    off < 1.5 * GOOD_RAD,
                    "{name} {azimuth_deg} {air_deg}: {off}"
                );
                compared += 1;
            }
        }
        assert!(compared > 40, "{name}: {compared}");
        let edge = found.eye.field.widest_rad();
        assert_eq!(edge, front.water_rad(half_deg.to_radians()));
        assert_eq!(found.eye.model_gap_rad(), None, "{name}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    for kappa in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(
            FrontElement::new(kappa),
            Err(FrontElementError::Kappa(_))
        ));
    }
    let pair = |air: f64, water: f64| {
        FrontElement::from_angles(air.to_radians(), water.to_radians())
            .unwrap_err()
            .to_string()
    };
    assert!(pair(105.0, 110.0).contains("to 105.00"));
    assert!(pair(105.0, 20.0).contains("flat port"));
    assert!(pair(5.0, 4.0).contains("20 to 130"));
    assert!(pair(f64::NAN, 4.0).contains("20 to 130"));
    assert!(pair(105.0, f64::NAN).contains("NaN"));
    let flat = FrontElement::new(1.0).unwrap();
    let model = CameraModel::Equidistant(Equidistant::new(250.0, [640.0, 480.0]).unwrap());
    assert!(matches!(
        flat.in_water(&eye(model, 105.0)),
        Err(FrontElementError::Grazing { .. })
    ));
    assert_eq!(flat.air_rad(1.0), None);
    assert_eq!(flat.air_rad(f64::NAN), None);
}
