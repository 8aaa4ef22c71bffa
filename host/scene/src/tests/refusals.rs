//! Bad input is refused by name, never by a panic.

use super::*;

fn refusal(change: impl Fn(&mut SceneDescription)) -> String {
    let mut description = SceneDescription::furnished(Medium::default());
    change(&mut description);
    Scene::new(&description)
        .expect_err("a bad description")
        .to_string()
}

fn water(change: impl Fn(&mut Water)) -> String {
    refusal(|d| {
        let mut water = Water::jerlov(JerlovType::OceanI);
        change(&mut water);
        d.medium = Medium::Water(water);
    })
}

#[test]
fn descriptions_with_impossible_numbers() {
    let nan = f64::NAN;
    let refusals = [
        refusal(|d| d.pool.length_m = nan),
        refusal(|d| d.pool.width_m = 0.0),
        refusal(|d| d.pool.depth_m = 1e9),
        refusal(|d| d.pool.freeboard_m = -0.1),
        refusal(|d| d.pool.tile_mm = 0.0),
        water(|w| w.refractive_index = 0.9),
        water(|w| w.attenuation_per_m[1] = -0.1),
        water(|w| w.backscatter_per_m[2] = f64::INFINITY),
        water(|w| w.veiling_light[0] = nan),
        water(|w| w.wave_slope = 2.0),
        refusal(|d| d.boards[1].columns = 0),
        refusal(|d| d.boards[1].rows = 4_000_000_000),
        refusal(|d| d.boards[0].square_mm = -30.0),
        refusal(|d| d.boards[2].pose.position_m[2] = nan),
        refusal(|d| d.boards[2].pose.roll_deg = f64::INFINITY),
        refusal(|d| d.boards = vec![d.boards[0]; 257]),
        refusal(|d| d.markers[3].id = 50),
        refusal(|d| d.markers[3].size_mm = 0.0),
        refusal(|d| d.markers[3].dictionary = "DICT_9X9".into()),
        refusal(|d| d.solids[0].color[0] = 1.5),
        refusal(|d| d.solids[0].band_mm = 0.0),
        refusal(|d| {
            d.solids[0].shape = Shape::Sphere {
                center_m: [0.0; 3],
                radius_mm: nan,
            };
        }),
        refusal(|d| {
            let (from_m, to_m) = ([1.0; 3], [1.0; 3]);
            d.solids[1].shape = Shape::Pole {
                from_m,
                to_m,
                radius_mm: 10.0,
            };
        }),
        refusal(|d| {
            let (center_m, size_mm) = ([0.0; 3], [1.0, 0.0, 1.0]);
            d.solids[2].shape = Shape::Box {
                center_m,
                size_mm,
                yaw_deg: 0.0,
            };
        }),
    ];
    insta::assert_snapshot!(refusals.join("\n"));
}

#[test]
fn pictures_and_options_out_of_range() {
    let scene = furnished();
    let view = equirect(8, 4, Pose::default());
    let with = |width, height, change: &dyn Fn(&mut RenderOptions)| {
        let mut options = RenderOptions::real_camera(0);
        change(&mut options);
        render(&scene, width, height, &view, &options)
            .expect_err("a bad option")
            .to_string()
    };
    let refusals = [
        with(0, 4, &|_| ()),
        with(u32::MAX, u32::MAX, &|_| ()),
        with(8, 4, &|o| o.samples_per_side = 0),
        with(8, 4, &|o| o.samples_per_side = 9),
        with(8, 4, &|o| o.blur_sigma_px = -1.0),
        with(8, 4, &|o| o.vignetting = f64::NAN),
        with(8, 4, &|o| o.exposure = f64::INFINITY),
        with(8, 4, &|o| {
            o.noise = Some(SensorNoise {
                full_well_e: 0.0,
                read_noise_e: 1.0,
            })
        }),
        with(8, 4, &|o| {
            o.noise = Some(SensorNoise {
                full_well_e: 1e4,
                read_noise_e: -1.0,
            })
        }),
    ];
    insta::assert_snapshot!(refusals.join("\n"));
}

#[test]
fn rays_that_start_nowhere() {
    let scene = furnished();
    let above_water = Ray::new(Point3::new(0.0, 0.0, 1.3), Vector3::x());
    assert!(matches!(
        scene.trace(&above_water),
        Err(Error::RayOutside { .. })
    ));
    let empty = Scene::new(&SceneDescription::furnished(Medium::Air)).unwrap();
    assert!(
        empty.trace(&above_water).is_ok(),
        "below the rim of an empty pool"
    );
    let no_direction = Ray::new(Point3::origin(), Vector3::zeros());
    assert!(matches!(
        scene.trace(&no_direction),
        Err(Error::RayNotFinite { .. })
    ));
    let nowhere = Ray::new(Point3::new(f64::NAN, 0.0, 0.0), Vector3::x());
    assert!(matches!(
        scene.radiance(&nowhere, 0.0),
        Err(Error::RayNotFinite { .. })
    ));
    let ahead = Ray::new(Point3::origin(), Vector3::x());
    assert!(matches!(
        scene.radiance(&ahead, f64::NAN),
        Err(Error::OutOfRange { .. })
    ));
}

#[test]
fn a_camera_outside_the_pool_is_an_error_and_one_without_rays_is_black() {
    let scene = furnished();
    let outside = equirect(
        8,
        4,
        Pose {
            position_m: Point3::new(7.0, 0.0, 0.0),
            ..Pose::default()
        },
    );
    let options = RenderOptions::default();
    let error = render(&scene, 8, 4, &outside, &options).unwrap_err();
    assert!(matches!(
        error,
        Error::RayOutside {
            origin_m: [7.0, 0.0, 0.0],
            ..
        }
    ));
    let blind = |_: f64, _: f64| None;
    let picture = render(&scene, 8, 4, &blind, &options).unwrap();
    assert!(picture.rgb.iter().all(|b| *b == 0));
    assert!(picture.truth.iter().all(Option::is_none));
}

#[test]
fn unknown_keys_are_refused_everywhere() {
    let text = toml::to_string(&SceneDescription::furnished(Medium::default())).unwrap();
    for key in [
        "depth_m",
        "wave_slope",
        "square_mm",
        "dictionary",
        "radius_mm",
        "yaw_deg",
    ] {
        let misspelt = text.replacen(&format!("{key} ="), &format!("{key}_ = 1\n{key} ="), 1);
        assert_ne!(misspelt, text);
        let error = toml::from_str::<SceneDescription>(&misspelt)
            .unwrap_err()
            .to_string();
        assert!(error.contains(&format!("{key}_")), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Any poses and sizes at all are refused or rendered.
    #[test]
    fn wild_numbers_never_panic(values in prop::array::uniform8(any::<f64>()), id in any::<u32>()) {
        let mut description = SceneDescription::furnished(Medium::default());
        let [a, b, c, d, e, f, g, h] = values;
        let tame = |v: f64| if v.is_finite() { v % 3.0 } else { v };
        description.boards[0].pose.position_m = [tame(a), tame(b), tame(c)];
        description.boards[0].pose.yaw_deg = tame(d) * 1000.0;
        description.boards[0].square_mm = e;
        description.markers[0].id = id % 60;
        description.solids[0].shape =
            Shape::Box { center_m: [tame(f), tame(g), tame(h)], size_mm: [a, b, c], yaw_deg: d };
        description.solids[3].shape =
            Shape::Pole { from_m: [tame(f), 0.0, 0.0], to_m: [0.0, tame(g), 0.0], radius_mm: h };
        if let Ok(scene) = Scene::new(&description) {
            let view = equirect(16, 8, Pose::default());
            prop_assert!(render(&scene, 16, 8, &view, &RenderOptions::default()).is_ok());
        }
    }
}
