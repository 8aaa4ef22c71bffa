use nalgebra::Vector3;

use super::*;

fn lenses() -> Vec<(Box<dyn Lens>, Vec<f64>)> {
    vec![
        (
            Box::new(OcamLens::new(5, 500.0).with_skew(true)),
            vec![640.0, 480.0, 1.001, 2e-3, 0.6, -0.3, 0.05, -0.1, 0.02],
        ),
        (
            Box::new(OcamLens::new(3, 500.0).with_decentring(true)),
            vec![640.0, 480.0, 1.001, 3e-3, -2e-3, 0.6, -0.3, 0.05],
        ),
        (
            Box::new(
                OcamLens::new(4, 500.0)
                    .with_skew(true)
                    .with_decentring(true),
            ),
            vec![
                640.0, 480.0, 1.001, 2e-3, -3e-3, 2e-3, 0.6, -0.3, -0.05, -0.01,
            ],
        ),
        (
            Box::new(OcamLens::new(4, 500.0)),
            vec![640.0, 480.0, 1.001, 0.6, -0.3, -0.05, -0.01],
        ),
        (
            Box::new(KannalaBrandtLens),
            vec![640.0, 480.0, 300.0, 301.0, -0.02, 0.003, -4e-4, 2e-5],
        ),
        (
            Box::new(DoubleSphereLens),
            vec![640.0, 480.0, 300.0, 302.0, -0.2, 0.6],
        ),
    ]
}

/// No camera, so that only what the solver asks of it is tested.
fn tilted() -> (Box<dyn Lens>, Vec<f64>) {
    let lens = OcamLens::new(3, 500.0).with_decentring(true);
    let p = vec![
        640.0, 480.0, 1.001, 3e-3, -2e-3, 0.6, -0.3, 0.05, 0.02, -0.03,
    ];
    (Box::new(TiltedLens::new(lens)), p)
}

fn rays() -> Vec<Vector3<f64>> {
    let angles = [0.0, 1e-6, 0.4, 1.2, 1.57, 1.8];
    let turned = angles.iter().enumerate().map(|(i, theta)| {
        let (sin, azimuth) = (libm::sin(*theta), i as f64);
        let flat = Vector3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), 0.0);
        (flat + Vector3::z() * libm::cos(*theta)) * (1.0 + azimuth)
    });
    turned.collect()
}

#[test]
fn derivatives_are_those_of_differences() {
    for (lens, p) in lenses().into_iter().chain([tilted()]) {
        for ray in rays() {
            let seen = lens.project(&p, &ray).expect("in the field");
            for axis in 0..3 {
                let step = 1e-5 * ray.norm();
                let at = |sign: f64| {
                    let mut ray = ray;
                    ray[axis] += sign * step;
                    lens.project(&p, &ray).expect("in the field").pixel
                };
                let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
                // Central differences: step^2 and rounding of 1e3 px over 1e-5.
                let error = (slope - seen.by_ray.column(axis)).norm();
                assert!(error < 1e-4, "{} {ray} {axis} {error}", lens.name());
            }
            for k in 0..lens.count() {
                let step = 1e-5 * p[k].abs().max(0.1);
                let at = |sign: f64| {
                    let mut p = p.clone();
                    p[k] += sign * step;
                    lens.project(&p, &ray).expect("in the field").pixel
                };
                let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
                let error = (slope - seen.by_lens[k]).norm();
                assert!(error < 1e-4, "{} {ray} p{k} {error}", lens.name());
            }
        }
    }
}

#[test]
fn pixels_and_rays_are_those_of_the_camera() {
    for (lens, p) in lenses() {
        // A polynomial goes on straight beyond its scale, the camera ends there.
        let camera = lens.camera(&p, 500.0).expect("a camera");
        let seen = rays().into_iter().filter(|ray| camera.project(ray).is_ok());
        let seen: Vec<Vector3<f64>> = seen.collect();
        assert!(seen.len() >= 4, "{}", lens.name());
        for ray in seen {
            let exact = camera.project(&ray).expect("in the field");
            let seen = lens.project(&p, &ray).expect("in the field").pixel;
            // The root is found to 1e-13 of the scale.
            assert!((seen.x - exact[0]).hypot(seen.y - exact[1]) < 1e-9);
            let back = lens.unproject(&p, [seen.x, seen.y]).expect("in the image");
            let angle = tectum_optics::convention::angle_between(&back, &ray);
            // The same over some 300 px a radian.
            assert!(angle < 1e-10, "{} {ray} {angle}", lens.name());
        }
        let names = lens.describe();
        let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
        let (again, q) = from_camera(&camera, &names).expect("a fitted model");
        assert_eq!(again.count(), lens.count());
        let ray = Vector3::new(1.0, -2.0, 0.3);
        let gap = again.project(&q, &ray).expect("in the field").pixel
            - lens.project(&p, &ray).expect("in the field").pixel;
        assert!(gap.norm() < 1e-9);
        assert_eq!(lens.describe().len(), lens.count());
    }
}

#[test]
fn a_tilted_sensor_has_its_ray_for_each_pixel() {
    let (lens, p) = tilted();
    assert_eq!(lens.count(), p.len());
    for ray in rays() {
        let seen = lens.project(&p, &ray).expect("in the field").pixel;
        let back = lens.unproject(&p, seen.into()).expect("in the image");
        let angle = tectum_optics::convention::angle_between(&back, &ray);
        // The root is found to 1e-13 of the scale, over some 300 px a radian.
        assert!(angle < 1e-10, "{ray} {angle}");
    }
    // The tilt stretches one side and shrinks the other.
    let at = |x: f64| {
        let ray = Vector3::new(x, 0.0, 0.0);
        lens.project(&p, &ray).expect("in the field").pixel.x - p[0]
    };
    let mut square = p.clone();
    square[8] = 0.0;
    square[9] = 0.0;
    let plain = |x: f64| {
        let ray = Vector3::new(x, 0.0, 0.0);
        lens.project(&square, &ray).expect("in the field").pixel.x - p[0]
    };
    assert!(at(1.0) < plain(1.0) && at(-1.0) < plain(-1.0));
}

#[test]
fn a_profile_is_met() {
    let profile: Vec<[f64; 2]> = (1..100)
        .map(|i| f64::from(i) * 0.018)
        .map(|theta| [300.0 * (theta - 0.01 * theta * theta * theta), theta])
        .collect();
    for (lens, _) in lenses() {
        let p = lens.meet_profile([1.0, 2.0], &profile).expect("a fit");
        for [rho, theta] in &profile {
            let ray = Vector3::new(0.0, libm::sin(*theta), libm::cos(*theta));
            let seen = lens.project(&p, &ray).expect("in the field").pixel;
            // Double sphere and degree 5 hold this lens to a few px at 100 degrees.
            assert!((seen.y - 2.0 - rho).abs() < 10.0, "{} {theta}", lens.name());
        }
    }
}
