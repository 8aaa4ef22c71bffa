//! The water's surface and its body against closed forms.

use super::*;

fn flat_water(attenuation_per_m: [f64; 3], veiling_light: [f64; 3]) -> Medium {
    Medium::Water(Water {
        refractive_index: 1.333,
        attenuation_per_m,
        backscatter_per_m: attenuation_per_m,
        veiling_light,
        wave_slope: 0.0,
    })
}

#[test]
fn snells_window_has_its_half_angle_in_the_rendered_truth() {
    let scene = Scene::new(&bare(flat_water([0.1; 3], [0.1; 3]))).unwrap();
    let pose = Pose {
        position_m: Point3::new(0.3, -0.2, 0.6),
        ..Pose::default()
    };
    let (width, height) = (360, 720);
    let view = equirect(width, height, pose);
    let options = RenderOptions {
        samples_per_side: 1,
        ..RenderOptions::default()
    };
    let picture = render(&scene, width, height, &view, &options).unwrap();
    let zenith_deg = |t: &Truth| libm::acos(t.direction[2]).to_degrees();
    let of = |seen: Seen| {
        picture
            .truth
            .iter()
            .flatten()
            .filter(move |t| t.seen == seen)
            .map(zenith_deg)
    };
    let widest_window = of(Seen::Window).fold(0.0, f64::max);
    let steepest_mirror = of(Seen::Mirror).fold(90.0, f64::min);
    let half_angle = libm::asin(1.0 / 1.333).to_degrees();
    assert!(
        (half_angle - 48.607).abs() < 1e-3,
        "the textbook's 48.6 degrees"
    );
    assert!(widest_window < half_angle && half_angle < steepest_mirror);
    // Rows are 0.25 degrees apart, so the two rows beside the rim are no further than that.
    assert!(steepest_mirror - widest_window < 0.2501);
}

#[test]
fn steep_rays_leave_the_water_and_an_empty_pool_has_no_surface() {
    let up = Ray::new(Point3::origin(), Vector3::new(0.5, 0.1, 1.0));
    let slant = Ray::new(Point3::origin(), Vector3::new(2.0, 0.1, 1.0));
    let scene = Scene::new(&bare(flat_water([0.0; 3], [0.0; 3]))).unwrap();
    assert_eq!(scene.trace(&up).unwrap().seen, Seen::Window);
    assert_eq!(scene.trace(&slant).unwrap().seen, Seen::Mirror);
    let empty = Scene::new(&bare(Medium::Air)).unwrap();
    assert_eq!(empty.trace(&up).unwrap().seen, Seen::Hall);
    assert_eq!(empty.trace(&up).unwrap().range_m, f64::INFINITY);
}

#[test]
fn the_mirror_shows_what_a_ray_from_it_meets() {
    let scene = Scene::new(&bare(flat_water([0.0; 3], [0.0; 3]))).unwrap();
    let eye = Ray::new(Point3::new(-1.0, 0.5, 0.2), Vector3::new(2.0, 0.3, 0.9));
    let hit = scene.trace(&eye).unwrap();
    assert_eq!(hit.seen, Seen::Mirror);
    let below = eye.at(hit.range_m) - Vector3::z() * 1e-9;
    let down = Ray::new(below, Vector3::new(2.0, 0.3, -0.9));
    let (mirrored, direct) = (
        scene.radiance(&eye, 0.0).unwrap(),
        scene.radiance(&down, 0.0).unwrap(),
    );
    for c in 0..3 {
        // The start is a nanometre lower; textures change by less than 1e3 a metre.
        assert!(
            (mirrored[c] - direct[c]).abs() < 1e-5,
            "{mirrored:?} {direct:?}"
        );
    }
}

#[test]
fn light_falls_off_as_the_image_formation_model_says() {
    let (attenuation, veil) = ([0.4, 0.12, 0.07], [0.05, 0.3, 0.4]);
    let Medium::Water(mut water) = flat_water(attenuation, veil) else {
        unreachable!()
    };
    water.backscatter_per_m = [0.3, 0.2, 0.1];
    let scene = Scene::new(&bare(Medium::Water(water))).unwrap();
    // The same point of the wall from 2 m and from 7 m along the same line.
    let target = Point3::new(6.0, 0.31, 0.13);
    let along = Vector3::new(1.0, 0.05, 0.02).normalize();
    let from = |range_m: f64| {
        let ray = Ray::new(target - along * range_m, along);
        let hit = scene.trace(&ray).unwrap();
        assert!((hit.range_m - range_m).abs() < 1e-12);
        Vector3::from(scene.radiance(&ray, 0.0).unwrap())
    };
    let (near, far) = (from(2.0), from(7.0));
    for c in 0..3 {
        let back = |r: f64| veil[c] * (1.0 - libm::exp(-water.backscatter_per_m[c] * r));
        let surface = (near[c] - back(2.0)) * libm::exp(attenuation[c] * 2.0);
        let expected = surface * libm::exp(-attenuation[c] * 7.0) + back(7.0);
        assert!(surface > 0.01, "there is a surface to see");
        // The two hits differ by 1e-15 m; textures change by less than 1e3 a metre.
        assert!((far[c] - expected).abs() < 1e-11, "channel {c}");
    }
}

#[test]
fn distant_water_is_its_veiling_light() {
    let veil = [0.1, 0.4, 0.5];
    let scene = Scene::new(&bare(flat_water([40.0; 3], veil))).unwrap();
    let light = scene
        .radiance(&Ray::new(Point3::origin(), Vector3::x()), 1e-3)
        .unwrap();
    // exp(-40 * 6) is nothing.
    assert_eq!(light, veil);
}
