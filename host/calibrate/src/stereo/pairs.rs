//! Which reading of the boards ties the eyes together.

use nalgebra::{Rotation3, Vector3};

use super::bundle::Eye;
use super::{MIN_PAIRS, StereoError};
use crate::solve::internal::{Pose, rotation};
use crate::{BoardPose, BoardSize};

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

/// A board that both eyes see in one shot, and how their labels may belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPair {
    /// Left camera <- the left view's labels.
    pub left: BoardPose,
    /// Right camera <- the right view's labels.
    pub right: BoardPose,
    /// Left labels <- right labels: every way that is possible.
    pub readings: Vec<BoardPose>,
    /// Points of the board in the right view's labels at which the eyes are compared, mm.
    pub points_mm: Vec<Vector3<f64>>,
}

/// What most pairs agree on.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Right camera <- left camera.
    pub relative: BoardPose,
    /// By pair: its reading, by index, if it agrees.
    pub readings: Vec<Option<usize>>,
    /// Pairs that agree.
    pub agreeing: usize,
    /// Most pairs that agree on anything else that reads one of these pairs otherwise.
    pub rival: usize,
}

impl BoardPair {
    fn relative(&self, reading: &BoardPose) -> BoardPose {
        // right <- left: P_R T^-1 P_L^-1, T = left labels <- right labels.
        let back = self.left.after(reading).inverse();
        self.right.after(&back)
    }

    /// Reading nearest to a relative pose, and the largest angle between where the right eye sees
    /// the points and where the relative pose puts them.
    fn nearest(&self, relative: &BoardPose) -> Option<(usize, f64)> {
        let off = |reading: &BoardPose| {
            let angles = self.points_mm.iter().map(|point| {
                let put = relative.apply(&self.left.apply(&reading.apply(point)));
                tectum_optics::convention::angle_between(&put, &self.right.apply(point))
            });
            angles.fold(0.0, f64::max)
        };
        let each = self.readings.iter().map(off).enumerate();
        each.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The relative pose of two eyes that most pairs agree on to within `tolerance_rad`, among those
/// that a single pair implies. `None` without pairs.
pub fn agreement(pairs: &[BoardPair], tolerance_rad: f64) -> Option<Agreement> {
    let implied = pairs
        .iter()
        .flat_map(|pair| pair.readings.iter().map(|reading| pair.relative(reading)));
    let fit = |relative: BoardPose| {
        let near = pairs.iter().map(|pair| {
            let nearest = pair.nearest(&relative);
            nearest.filter(|(_, off)| *off < tolerance_rad)
        });
        let near: Vec<_> = near.collect();
        let sum = near.iter().flatten().map(|(_, off)| off).sum::<f64>();
        let readings: Vec<_> = near.iter().map(|near| near.map(|(k, _)| k)).collect();
        let agreeing = readings.iter().flatten().count();
        (agreeing, sum, readings, relative)
    };
    let fits: Vec<_> = implied.map(fit).collect();
    let best = fits
        .iter()
        .min_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)))?;
    let contradicts = |readings: &[Option<usize>]| {
        let both = readings.iter().zip(&best.2);
        both.into_iter()
            .any(|(a, b)| a.is_some() && b.is_some() && a != b)
    };
    let rivals = fits.iter().filter(|fit| contradicts(&fit.2));
    Some(Agreement {
        relative: best.3,
        rival: rivals.map(|fit| fit.0).max().unwrap_or_default(),
        readings: best.2.clone(),
        agreeing: best.0,
    })
}

/// Right camera <- left camera (squares) in which most pairs agree, and by pair the map from the
/// right view's labels to the left view's, if the pair agrees.
pub fn agree(eyes: &[Eye; 2], size: BoardSize) -> Result<(Pose, Vec<Option<Pose>>), StereoError> {
    let [left, right] = eyes;
    let turns = turns(size);
    // One square is one unit of length.
    let posed = |pose: &Pose| BoardPose {
        rotation: Rotation3::from_matrix_unchecked(pose.rotation),
        position_mm: pose.position,
    };
    let middle = Vector3::new(
        f64::from(size.columns) / 2.0,
        f64::from(size.rows) / 2.0,
        0.0,
    );
    let corner = Vector3::new(2.0 * middle.x - 1.0, 0.0, 0.0);
    let both = (0..left.poses.len()).filter_map(|k| {
        let pair = BoardPair {
            left: posed(left.poses[k].as_ref()?),
            right: posed(right.poses[k].as_ref()?),
            readings: turns.iter().map(posed).collect(),
            points_mm: vec![middle, Vector3::zeros(), corner],
        };
        Some((k, pair))
    });
    let (places, pairs): (Vec<usize>, Vec<BoardPair>) = both.unzip();
    let best = agreement(&pairs, AGREES_RAD);
    let agreeing = best.as_ref().map_or(0, |best| best.agreeing);
    let Some(best) = best.filter(|best| best.agreeing >= MIN_PAIRS) else {
        return Err(StereoError::TooFewPairs {
            agreeing,
            both: pairs.len(),
            needed: MIN_PAIRS,
        });
    };
    let mut result = vec![None; left.poses.len()];
    for (place, reading) in places.into_iter().zip(best.readings) {
        result[place] = reading.map(|turn| turns[turn]);
    }
    let relative = Pose {
        rotation: best.relative.rotation.into_inner(),
        position: best.relative.position_mm,
    };
    Ok((relative, result))
}
