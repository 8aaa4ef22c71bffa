//! Which reading of the boards ties the eyes together.

use nalgebra::{Matrix3, Vector3};

use super::bundle::Eye;
use super::{MIN_PAIRS, StereoError};
use crate::BoardSize;
use crate::solve::internal::{Pose, rotation};

/// Directions of the other eye's corners that differ by less than this agree, rad: more than two
/// separately calibrated eyes are off, far less than a board turned round.
const AGREES_RAD: f64 = 0.03;

/// Ways to turn a board so that its corners fall on corners, as maps of labels (squares).
fn turns(size: BoardSize) -> Vec<Pose> {
    let [w, h] = [size.columns, size.rows].map(|n| f64::from(n) - 1.0);
    let quarter = |quarters: f64, x: f64, y: f64| Pose {
        rotation: rotation(&(Vector3::z() * quarters * std::f64::consts::FRAC_PI_2)),
        position: Vector3::new(x, y, 0.0),
    };
    let mut turns = vec![quarter(0.0, 0.0, 0.0), quarter(2.0, w, h)];
    if size.columns == size.rows {
        turns.push(quarter(1.0, w, 0.0));
        turns.push(quarter(3.0, 0.0, h));
    }
    turns
}

fn after(a: &Pose, b: &Pose) -> Pose {
    Pose {
        rotation: a.rotation * b.rotation,
        position: a.rotation * b.position + a.position,
    }
}

fn inverse(a: &Pose) -> Pose {
    let back: Matrix3<f64> = a.rotation.transpose();
    Pose {
        rotation: back,
        position: -(back * a.position),
    }
}

/// Right camera <- left camera (squares) in which most pairs agree, and by pair the map from the
/// right view's labels to the left view's, if the pair agrees.
pub fn agree(eyes: &[Eye; 2], size: BoardSize) -> Result<(Pose, Vec<Option<Pose>>), StereoError> {
    let [left, right] = eyes;
    let turns = turns(size);
    // right <- left of each pair and reading: P_R T^-1 P_L^-1, T = left labels <- right labels.
    let both: Vec<(usize, &Pose, &Pose)> = (0..left.poses.len())
        .filter_map(|k| Some((k, left.poses[k].as_ref()?, right.poses[k].as_ref()?)))
        .collect();
    let readings: Vec<Vec<Pose>> = both
        .iter()
        .map(|(_, l, r)| {
            let relative = |turn: &Pose| after(&after(r, &inverse(turn)), &inverse(l));
            turns.iter().map(relative).collect()
        })
        .collect();
    let middle = Vector3::new(
        f64::from(size.columns) / 2.0,
        f64::from(size.rows) / 2.0,
        0.0,
    );
    // Angle between where the right eye sees points of the board and where `relative` puts them.
    let off = |relative: &Pose, pair: usize, turn: usize| {
        let (_, l, r) = both[pair];
        let points = [
            middle,
            Vector3::zeros(),
            Vector3::new(2.0 * middle.x - 1.0, 0.0, 0.0),
        ];
        let angles = points.map(|point| {
            let on_left = turns[turn].rotation * point + turns[turn].position;
            let put = relative.apply(&l.apply(&on_left));
            tectum_optics::convention::angle_between(&put, &r.apply(&point))
        });
        angles.into_iter().fold(0.0, f64::max)
    };
    let nearest = |relative: &Pose, pair: usize| {
        let each = (0..turns.len()).map(|turn| (turn, off(relative, pair, turn)));
        each.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let mut best: Option<(usize, f64, Pose)> = None;
    for relative in readings.iter().flatten() {
        let fits = (0..both.len()).filter_map(|pair| nearest(relative, pair));
        let fits: Vec<f64> = fits
            .map(|fit| fit.1)
            .filter(|off| *off < AGREES_RAD)
            .collect();
        let sum = fits.iter().sum::<f64>();
        let better = best.as_ref().is_none_or(|(count, least, _)| {
            fits.len() > *count || (fits.len() == *count && sum < *least)
        });
        if better {
            best = Some((fits.len(), sum, *relative));
        }
    }
    let agreeing = best.as_ref().map_or(0, |best| best.0);
    let Some((_, _, relative)) = best.filter(|best| best.0 >= MIN_PAIRS) else {
        return Err(StereoError::TooFewPairs {
            agreeing,
            both: both.len(),
            needed: MIN_PAIRS,
        });
    };
    let mut result = vec![None; left.poses.len()];
    for (pair, (k, ..)) in both.iter().enumerate() {
        result[*k] = nearest(&relative, pair)
            .filter(|(_, off)| *off < AGREES_RAD)
            .map(|(turn, _)| turns[turn]);
    }
    Ok((relative, result))
}
