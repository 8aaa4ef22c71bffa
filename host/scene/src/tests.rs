//! What only the whole scene can show.

mod optics;
mod prints;
mod refusals;

use crate::camera::{Pose, equirect};
use crate::*;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn furnished() -> Scene {
    Scene::new(&SceneDescription::furnished(Medium::default())).unwrap()
}

/// A bare basin of 12 x 8 x 2.4 m.
fn bare(medium: Medium) -> SceneDescription {
    let mut description = SceneDescription::furnished(medium);
    description.boards.clear();
    description.markers.clear();
    description.solids.clear();
    description
}

#[test]
fn any_number_of_threads_makes_the_same_picture() {
    let scene = furnished();
    let view = equirect(97, 53, Pose::default());
    let options = RenderOptions::real_camera(5);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| render(&scene, 97, 53, &view, &options).unwrap())
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(5));
    let other_seed = RenderOptions { seed: 6, ..options };
    let other = render(&scene, 97, 53, &view, &other_seed).unwrap();
    assert_ne!(one.rgb, other.rgb, "the seed changes the noise");
    assert_eq!(one.truth, other.truth, "and nothing else");
}

#[test]
fn the_sphere_around_the_fish_reads_as_text() {
    let view = equirect(72, 24, Pose::default());
    let picture = render(&furnished(), 72, 24, &view, &RenderOptions::default()).unwrap();
    let letter = |truth: &Option<Truth>| match truth.map(|t| t.seen) {
        None => ' ',
        Some(Seen::Floor) => '.',
        Some(Seen::Wall(_)) => '|',
        Some(Seen::Window) => 'O',
        Some(Seen::Mirror) => '~',
        Some(Seen::Hall) => '^',
        Some(Seen::Board(_)) => '#',
        Some(Seen::Marker(_)) => 'M',
        Some(Seen::Backing) => 'x',
        Some(Seen::Solid(_)) => 'o',
    };
    let rows = picture
        .truth
        .chunks(72)
        .map(|row| row.iter().map(letter).collect::<String>());
    insta::assert_snapshot!(rows.collect::<Vec<_>>().join("\n"));
}

#[test]
fn a_description_survives_toml() {
    for medium in [Medium::Air, Medium::default()] {
        let description = SceneDescription::furnished(medium);
        let text = toml::to_string(&description).unwrap();
        assert_eq!(
            toml::from_str::<SceneDescription>(&text).unwrap(),
            description,
            "{text}"
        );
    }
}

#[test]
fn a_filtered_sample_is_nearer_the_mean_of_many_than_a_point_sample() {
    let scene = Scene::new(&bare(Medium::Air)).unwrap();
    let cone_rad = 0.02;
    let (mut filtered, mut aliased) = (0.0, 0.0);
    for k in 0..400 {
        // A golden-angle spiral over the lower half of the sphere: floor and walls.
        let (s, c) = libm::sincos(2.399963 * f64::from(k));
        let z = -(f64::from(k) + 0.5) / 400.0;
        let flat = (1.0 - z * z).sqrt();
        let along = Vector3::new(flat * c, flat * s, z);
        let (across, up) = (
            Vector3::new(-s, c, 0.0),
            along.cross(&Vector3::new(-s, c, 0.0)),
        );
        let green = |i: f64, j: f64, cone: f64| {
            let direction = along + (across * i + up * j) * cone_rad;
            scene
                .radiance(&Ray::new(Point3::origin(), direction), cone)
                .unwrap()[1]
        };
        let grid = |n: i32| (f64::from(n) + 0.5) / 16.0 - 0.5;
        let many: f64 = (0..256)
            .map(|n| green(grid(n % 16), grid(n / 16), 0.0))
            .sum::<f64>()
            / 256.0;
        filtered += (green(0.0, 0.0, cone_rad) - many).powi(2);
        aliased += (green(0.0, 0.0, 0.0) - many).powi(2);
    }
    // 80 mm on a wall 4 m away covers whole joints of the 150 mm tiles: a third is a loose bound.
    assert!(
        filtered.sqrt() < aliased.sqrt() / 3.0,
        "{} {}",
        filtered.sqrt(),
        aliased.sqrt()
    );
}

proptest! {
    #[test]
    fn every_ray_from_inside_meets_something_where_it_says(
        origin in (-5.9..5.9f64, -3.9..3.9f64, -1.15..1.15f64),
        along in prop::array::uniform3(-1.0..1.0f64),
        water in any::<bool>(),
    ) {
        prop_assume!(Vector3::from(along).norm() > 1e-3);
        let medium = if water { Medium::default() } else { Medium::Air };
        let scene = Scene::new(&bare(medium)).unwrap();
        let ray = Ray::new(Point3::new(origin.0, origin.1, origin.2), along.into());
        let hit = scene.trace(&ray).unwrap();
        let light = scene.radiance(&ray, 1e-3).unwrap();
        prop_assert!(light.iter().all(|l| l.is_finite() && *l >= 0.0 && *l < 10.0), "{light:?}");
        if hit.seen == Seen::Hall {
            prop_assert!(!water && ray.direction.z > 0.0);
            return Ok(());
        }
        let at = ray.at(hit.range_m);
        let (gap, surface_m) = match hit.seen {
            Seen::Floor => (at.z + 1.2, [at.x, at.y]),
            Seen::Wall(Wall::Front) => (at.x - 6.0, [at.y, at.z]),
            Seen::Wall(Wall::Back) => (at.x + 6.0, [at.y, at.z]),
            Seen::Wall(Wall::Left) => (at.y - 4.0, [at.x, at.z]),
            Seen::Wall(Wall::Right) => (at.y + 4.0, [at.x, at.z]),
            Seen::Window | Seen::Mirror => (at.z - 1.2, [at.x, at.y]),
            other => return Err(TestCaseError::fail(format!("{other:?} in a bare pool"))),
        };
        // Ranges of up to 15 m carry 2e-15 of rounding each step.
        prop_assert!(gap.abs() < 1e-12, "{hit:?}");
        prop_assert_eq!(hit.surface_m, surface_m);
        prop_assert!(at.x.abs() < 6.0 + 1e-12 && at.y.abs() < 4.0 + 1e-12);
    }
}

#[test]
fn rays_along_the_axes_meet_the_faces() {
    let scene = Scene::new(&bare(Medium::default())).unwrap();
    let see = |x, y, z| {
        let hit = scene
            .trace(&Ray::new(Point3::origin(), Vector3::new(x, y, z)))
            .unwrap();
        (hit.seen, hit.range_m)
    };
    assert_eq!(see(1.0, 0.0, 0.0), (Seen::Wall(Wall::Front), 6.0));
    assert_eq!(see(-1.0, 0.0, 0.0), (Seen::Wall(Wall::Back), 6.0));
    assert_eq!(see(0.0, 1.0, 0.0), (Seen::Wall(Wall::Left), 4.0));
    assert_eq!(see(0.0, -1.0, 0.0), (Seen::Wall(Wall::Right), 4.0));
    assert_eq!(see(0.0, 0.0, -1.0), (Seen::Floor, 1.2));
    assert_eq!(see(0.0, 0.0, 1.0), (Seen::Window, 1.2));
}
