//! Lenses from either half of a real session: nothing is known of the true lens, but what both state must
//! cover their difference. This is mrcal's cross-validation (Kogan 2021).

use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_calibrate::Calibration;
use tectum_calibrate::solve::{AngularUncertainty, calibrate};
use tectum_optics::convention::angle_between;

use crate::random::best_rotation;
use crate::sets::{Set, real};

/// Samples along the longer side of the picture.
const SAMPLES: u32 = 64;

/// Differences between the rays of two lenses and what both state of them together, rad, over the part of
/// the picture that the boards of both reach; the best common rotation taken off.
fn differences(halves: &[Calibration; 2]) -> Vec<[f64; 2]> {
    let stated = halves
        .each_ref()
        .map(|half| AngularUncertainty::new(half).expect("a model"));
    let [width, height] = halves[0].size_px;
    let pitch = f64::from(width.max(height)) / f64::from(SAMPLES);
    let mut rays = Vec::new();
    for index in 0..SAMPLES * SAMPLES {
        let pixel = [index % SAMPLES, index / SAMPLES].map(|k| (f64::from(k) + 0.5) * pitch - 0.5);
        if pixel[0] > f64::from(width) || pixel[1] > f64::from(height) {
            continue;
        }
        let of = |k: usize| -> Option<(Vector3<f64>, f64)> {
            let ray = halves[k].model.unproject(pixel).ok()?.normalize();
            let is_reached = ray.angle(&Vector3::z()) <= halves[k].field_rad;
            let sigma = stated[k].rotation_free_sigma_rad(pixel)?;
            is_reached.then_some((ray, sigma))
        };
        if let (Some(a), Some(b)) = (of(0), of(1)) {
            rays.push((a.0, b.0, libm::hypot(a.1, b.1)));
        }
    }
    let best = best_rotation(rays.iter().map(|(a, b, _)| (*a, *b)));
    rays.iter()
        .map(|(a, b, stated)| [angle_between(&(best * b), a), *stated])
        .collect()
}

/// Share of the picture over which both halves' stated errors cover their difference twice; `None` where
/// a half is no calibration.
fn share(set: &Set) -> Option<f64> {
    let half = |first: usize| {
        let views: Vec<usize> = (first..set.problem.views.len()).step_by(2).collect();
        calibrate(&set.part(&views), &set.options)
    };
    let halves = match (half(0), half(1)) {
        (Ok(a), Ok(b)) => [a, b],
        (Err(error), _) | (_, Err(error)) => {
            println!("{} | {error}", set.name);
            return None;
        }
    };
    let all = differences(&halves);
    let covered = all.iter().filter(|[apart, stated]| *apart <= 2.0 * stated);
    let share = covered.count() as f64 / all.len().max(1) as f64;
    let rms = |k: usize| {
        let sum: f64 = all.iter().map(|pair| pair[k] * pair[k]).sum();
        (sum / all.len().max(1) as f64).sqrt().to_degrees()
    };
    println!(
        "{} | {} and {} | {:.3} | {:.3} | {:.1}",
        set.name,
        halves[0].views_used(),
        halves[1].views_used(),
        rms(0),
        rms(1),
        100.0 * share
    );
    Some(share)
}

#[test]
#[ignore = "campaign calibration: 22 calibrations"]
fn halves_of_real_sessions_differ_by_what_they_state() {
    let sets = real("");
    if sets.is_empty() {
        return;
    }
    println!("set | pictures | halves apart, degrees RMS | stated of both | covered twice, %");
    let shares: Vec<f64> = sets.par_iter().filter_map(share).collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    println!(
        "{} real sets: {:.1} % of the picture",
        shares.len(),
        100.0 * mean
    );
    assert!(mean >= 0.9, "{mean}");
}
