//! Pictures turned and scaled by known amounts; tiles of a known rig.

use image::{GrayImage, Luma};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_optics::Rig;

use super::*;

/// Bright and dark spots of all sizes.
struct Spots(Vec<[f64; 4]>);

const SIDE: u32 = 260;

impl Spots {
    fn new() -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let spot = || {
            let [x, y] = [0, 0].map(|_| rng.random_range(-40.0..300.0));
            let sigma: f64 = rng.random_range(1.8..7.0);
            let height = if rng.random() { 45.0 } else { -45.0 };
            [x, y, sigma, height]
        };
        Self(std::iter::repeat_with(spot).take(420).collect())
    }

    fn luma(&self, [x, y]: [f64; 2]) -> f64 {
        let spots = self.0.iter().map(|[cx, cy, sigma, height]| {
            let d2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (sigma * sigma);
            if d2 > 16.0 {
                0.0
            } else {
                height * libm::exp(-d2 / 2.0)
            }
        });
        128.0 + spots.sum::<f64>()
    }

    /// The picture whose pixels show where `place` says.
    fn picture(&self, place: impl Fn([f64; 2]) -> [f64; 2]) -> GrayImage {
        GrayImage::from_fn(SIDE, SIDE, |x, y| {
            let luma = self.luma(place([f64::from(x), f64::from(y)]));
            Luma([luma.round().clamp(0.0, 255.0) as u8])
        })
    }
}

/// A turn about the picture's middle and a scale.
#[derive(Clone, Copy)]
struct Similarity {
    turn_deg: f64,
    scale: f64,
}

impl Similarity {
    fn apply(&self, [x, y]: [f64; 2], scale: f64, turn_deg: f64) -> [f64; 2] {
        let middle = f64::from(SIDE - 1) / 2.0;
        let (sin, cos) = libm::sincos(turn_deg.to_radians());
        let [u, v] = [x - middle, y - middle];
        [
            middle + scale * (cos * u - sin * v),
            middle + scale * (sin * u + cos * v),
        ]
    }

    /// Where a point of the first picture is in the second.
    fn forth(&self, p: [f64; 2]) -> [f64; 2] {
        self.apply(p, self.scale, self.turn_deg)
    }

    fn back(&self, p: [f64; 2]) -> [f64; 2] {
        self.apply(p, 1.0 / self.scale, -self.turn_deg)
    }
}

struct Outcome {
    repeated: f64,
    matches: usize,
    right: f64,
}

fn near(a: [f64; 2], b: [f64; 2], px: f64) -> bool {
    libm::hypot(a[0] - b[0], a[1] - b[1]) < px
}

/// Points are the same within this, px of the second picture.
const SAME_PX: f64 = 2.5;

fn outcome(detector: &Detector, change: Similarity) -> Outcome {
    let spots = Spots::new();
    let inside = |p: [f64; 2]| {
        let margin = 30.0;
        p.iter()
            .all(|c| (margin..f64::from(SIDE) - margin).contains(c))
    };
    let both = |p: [f64; 2]| inside(p) && inside(change.forth(p));
    let first = detector
        .detect(&spots.picture(|p| p), &both)
        .expect("no network");
    let second = detector
        .detect(&spots.picture(|p| change.back(p)), &|p| {
            both(change.back(p))
        })
        .expect("no network");
    let repeated = |keypoint: &&Keypoint| {
        let there = change.forth(keypoint.position_px);
        let mut others = second.keypoints.iter();
        others.any(|other| near(there, other.position_px, SAME_PX))
    };
    let matches = mutual_matches(&first, &second, LOWE_RATIO);
    let right = matches.iter().filter(|m| {
        let there = change.forth(first.keypoints[m.left].position_px);
        near(there, second.keypoints[m.right].position_px, SAME_PX)
    });
    Outcome {
        repeated: first.keypoints.iter().filter(repeated).count() as f64 / first.len() as f64,
        right: right.count() as f64 / matches.len().max(1) as f64,
        matches: matches.len(),
    }
}

fn detector(matcher: Matcher) -> Detector {
    Detector::new(matcher, None).unwrap()
}

#[test]
fn sift_survives_turns_and_scales() {
    for matcher in [Matcher::Sift, Matcher::RootSift] {
        for (turn_deg, scale) in [
            (0.0, 1.0),
            (37.0, 1.0),
            (180.0, 1.0),
            (75.0, 1.4),
            (-20.0, 0.7),
        ] {
            let found = outcome(&detector(matcher), Similarity { turn_deg, scale });
            println!(
                "{} {turn_deg} deg x{scale}: {:.2} repeated, {} matches, {:.2} right",
                matcher.name(),
                found.repeated,
                found.matches,
                found.right
            );
            // Lowe 2004, Fig. 3-6: 80 to 90 % of the points are found again, nearly all of what passes
            // the ratio test is right. A smaller picture has lost the smallest spots.
            assert!(found.repeated > 0.8, "{}", found.repeated);
            assert!(found.right > 0.98 && found.matches > 40, "{}", found.right);
        }
    }
}

#[test]
fn orb_survives_turns_and_small_scales() {
    for (turn_deg, scale) in [(0.0, 1.0), (37.0, 1.0), (180.0, 1.0), (75.0, 1.2)] {
        let found = outcome(&detector(Matcher::Orb), Similarity { turn_deg, scale });
        println!(
            "orb {turn_deg} deg x{scale}: {:.2} repeated, {} matches, {:.2} right",
            found.repeated, found.matches, found.right
        );
        // Rublee et al. 2011, Fig. 7: 70 % of the matches and more are right at any turn.
        assert!(found.repeated > 0.6, "{}", found.repeated);
        assert!(found.right > 0.7 && found.matches > 30, "{}", found.right);
    }
}

#[test]
fn upright_features_do_not_turn() {
    let still = outcome(
        &Detector::upright(),
        Similarity {
            turn_deg: 0.0,
            scale: 1.0,
        },
    );
    assert!(still.right > 0.99, "{}", still.right);
    let turned = outcome(
        &Detector::upright(),
        Similarity {
            turn_deg: 90.0,
            scale: 1.0,
        },
    );
    // A quarter turn leaves hardly a match, and those by chance.
    assert!((turned.matches as f64 * turned.right) < 0.05 * still.matches as f64);
}

#[test]
fn flat_and_tiny_pictures_have_no_features() {
    for side in [1, 7, 40] {
        let flat = GrayImage::from_pixel(side, side, Luma([90]));
        for matcher in [Matcher::Sift, Matcher::RootSift, Matcher::Orb] {
            let found = detector(matcher).detect(&flat, &|_| true).unwrap();
            assert!(found.is_empty() && found.descriptors.is_empty());
        }
    }
}

#[test]
fn detectors_are_told_by_name() {
    for matcher in Matcher::ALL {
        assert_eq!(matcher.name().parse(), Ok(matcher));
    }
    let error = "surf".parse::<Matcher>().unwrap_err();
    assert_eq!(error, DetectorError::Unknown("surf".into()));
    assert!(Detector::new(Matcher::SuperPoint, None).is_err());
}

/// Two eyes of 210 degrees, 20 cm apart, that look out to both sides and `ahead_deg` forward.
fn rig(ahead_deg: f64) -> Rig {
    let eye = |name: &str, side: f64| {
        format!(
            "[{name}]\nsize_px = [400, 400]\nfield_deg = 210.0\n\
             pose = {{ yaw_deg = {}, pitch_deg = -5.0, position_mm = [0.0, {}, 0.0] }}\n\
             lens = {{ model = 'equidistant', focal_px_per_rad = 105.0, \
             centre_px = [199.5, 199.5] }}\n",
            side * (90.0 - ahead_deg),
            side * 100.0
        )
    };
    let text = format!(
        "name = 'two'\nmedium = 'air'\nstitch_distance_m = inf\n{}{}",
        eye("left", 1.0),
        eye("right", -1.0)
    );
    Rig::from_toml(&text, "two").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_tile_shows_a_point_of_both_eyes_on_one_column() {
    for ahead_deg in [0.0, 20.0] {
        let overlap = Overlap::new(&rig(ahead_deg), 0.0).unwrap();
        let tile = Tile::new(&overlap).unwrap();
        let mut seen = 0;
        for i in 0..300 {
            let azimuth = f64::from(i) * 0.7;
            let across = 0.06 * f64::from(i % 7 - 3);
            let point = Vector3::new(libm::cos(azimuth), across, libm::sin(azimuth)) * 0.9;
            let pixel = |eye: usize| {
                let rig_eye = &overlap.eyes[eye];
                let px = rig_eye.pixel_of(&point.normalize(), point.norm()).ok()?;
                Some(tile.position_px(&overlap.ray(eye, px)?))
            };
            let (Some(left), Some(right)) = (pixel(0), pixel(1)) else {
                continue;
            };
            seen += 1;
            // Rounding of the camera model there and back.
            assert!((left[0] - right[0]).abs() < 1e-6, "{left:?} {right:?}");
            // Near things are apart along the column.
            assert!((left[1] - right[1]).abs() > 1.0);
        }
        assert!(seen > 20, "{seen}");
    }
}

#[test]
fn positions_of_a_tile_go_there_and_back() {
    for ahead_deg in [0.0, 20.0] {
        let overlap = Overlap::new(&rig(ahead_deg), 0.0).unwrap();
        let tile = Tile::new(&overlap).unwrap();
        let [width, height] = tile.size_px();
        let mut counted = 0;
        for y in (0..height).step_by(9) {
            for x in (0..width).step_by(9) {
                let position = [f64::from(x), f64::from(y)];
                if !tile.counts(position) {
                    continue;
                }
                counted += 1;
                let ray = tile.ray(position).unwrap();
                let back = tile.position_px(&ray);
                assert!(near(back, position, 1e-6), "{position:?} {back:?}");
                assert!(tile.raw_px(0, position).is_some() && tile.raw_px(1, position).is_some());
            }
        }
        assert!(counted > 100, "{counted}");
    }
}

#[test]
fn eyes_that_share_nothing_have_no_tile() {
    let mut rig = rig(0.0);
    for (eye, side) in [(&mut rig.left, 1.0), (&mut rig.right, -1.0)] {
        let eye = eye.as_mut().unwrap();
        eye.eye.field = tectum_optics::Field::new(vec![80f64.to_radians()]).unwrap();
        eye.pose.position_m.y = 0.1 * side;
    }
    let overlap = Overlap::new(&rig, 0.0).unwrap();
    assert!(!overlap.exists());
    assert_eq!(Tile::new(&overlap), None);
    let picture = Spots::new().picture(|p| p);
    let big = image::imageops::resize(&picture, 400, 400, image::imageops::FilterType::Triangle);
    for view in [View::Raw, View::Calibrated] {
        let found = shot_features(&overlap, [&big, &big], &detector(Matcher::Orb), view).unwrap();
        assert!(found[0].is_empty() && found[1].is_empty());
        assert!(correspond(&found, 0, LOWE_RATIO).is_empty());
    }
}
