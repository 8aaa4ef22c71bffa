//! What is missing.

use nalgebra::Vector3;
use tectum_optics::convention::angle_between;

use super::cells::{Cell, Direction, RING_RAD};
use super::{Coverage, Place, Shown};

/// Pictures that should show a board in every part of the field.
const WANTED_PICTURES: usize = 4;
/// Fewer pictures in a cell than this are a gap: what one picture says nothing checks.
const LEAST_PICTURES: usize = 2;
/// Fewer pictures than this are too few altogether: OCamCalib's manual asks for ten.
pub(super) const LEAST_ALTOGETHER: usize = 10;
/// Edges of the field this near to the outermost corners count as reached: half a ring.
const REACHED_RAD: f64 = RING_RAD / 2.0;
/// Reaches are told in steps of this, degrees.
const STEP_DEG: f64 = 5.0;
/// Boards whose normals all lie within this are parallel, rad. Parallel boards leave the focal
/// length free (Zhang 2000, section 4).
const PARALLEL_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Farthest over nearest below this is one distance.
const ONE_DISTANCE: f64 = 1.25;

/// Something that more pictures would mend.
#[derive(Debug, Clone, PartialEq)]
pub enum Gap {
    /// Too few pictures with a board.
    FewPictures {
        /// Pictures with a board.
        pictures: usize,
    },
    /// No board beyond an angle, though the lens and the sensor show more there.
    Beyond {
        /// Angle off axis up to which boards reach, rad, a multiple of 5 degrees.
        angle_rad: f64,
        /// Where, neighbours in order.
        directions: Vec<Direction>,
        /// Pictures to take.
        take: usize,
    },
    /// A hole inside what the boards cover.
    Between {
        /// Inner edge, off axis, rad.
        from_rad: f64,
        /// Outer edge, off axis, rad.
        to_rad: f64,
        /// Where, neighbours in order; empty for the middle of the picture.
        directions: Vec<Direction>,
        /// Pictures that show a board there, 0 or 1.
        pictures: usize,
        /// Pictures to take.
        take: usize,
    },
    /// All boards are parallel to each other.
    Parallel {
        /// Greatest angle of a board from the mean of all, rad.
        spread_rad: f64,
    },
    /// All boards are at one distance.
    OneDistance {
        /// Nearest, mm.
        nearest_mm: f64,
        /// Farthest, mm.
        farthest_mm: f64,
    },
}

/// Pictures to take where boards of `pictures` show `sectors` neighbours: a board near the eye
/// spans about two.
fn take(pictures: usize, sectors: usize) -> usize {
    (WANTED_PICTURES - pictures.min(WANTED_PICTURES)) * sectors.div_ceil(2).max(1)
}

/// What is missing, what matters most first.
pub(super) fn find(coverage: &Coverage, shown: &[Shown]) -> Vec<Gap> {
    let pictures = shown
        .iter()
        .filter(|one| !one.corners_px.is_empty())
        .count();
    let mut gaps = Vec::new();
    if pictures < LEAST_ALTOGETHER {
        gaps.push(Gap::FewPictures { pictures });
    }
    if pictures > 0 {
        gaps.extend(beyond(coverage));
        gaps.extend(between(coverage));
    }
    let places: Vec<Place> = shown.iter().filter_map(|one| one.place).collect();
    gaps.extend(poses(&places));
    gaps
}

fn beyond(coverage: &Coverage) -> Vec<Gap> {
    let short: [Option<f64>; 8] = std::array::from_fn(|i| {
        let (reach, limit) = (coverage.reach_rad[i], coverage.limit_rad[i]);
        let told = (libm::ceil(reach.to_degrees() / STEP_DEG - 1e-9) * STEP_DEG).to_radians();
        (limit - reach > REACHED_RAD && told < limit).then_some(told)
    });
    // Neighbours within two steps make one sentence.
    let alike = |a: &f64, b: &f64| (a - b).abs().to_degrees() < 2.5 * STEP_DEG;
    runs(&short, alike)
        .into_iter()
        .map(|run| Gap::Beyond {
            angle_rad: run.iter().filter_map(|i| short[*i]).fold(0.0, f64::max),
            take: take(0, run.len()),
            directions: run.iter().map(|i| Direction::ALL[*i]).collect(),
        })
        .collect()
}

fn between(coverage: &Coverage) -> Vec<Gap> {
    let thin = |cell: &Cell, reach: f64| {
        (cell.visible && cell.from_rad < reach && cell.pictures < LEAST_PICTURES)
            .then_some(cell.pictures)
    };
    let (centre, rings) = match coverage.cells.split_first() {
        Some((centre, rings)) => (centre, rings),
        None => return Vec::new(),
    };
    let gap = |cell: &Cell, pictures: usize, run: &[usize]| Gap::Between {
        from_rad: cell.from_rad,
        to_rad: cell.to_rad,
        directions: run.iter().map(|i| Direction::ALL[*i]).collect(),
        pictures,
        take: take(pictures, run.len()),
    };
    let mut gaps = Vec::new();
    gaps.extend(thin(centre, RING_RAD).map(|pictures| gap(centre, pictures, &[])));
    for ring in rings.chunks_exact(8) {
        let seen: [Option<usize>; 8] =
            std::array::from_fn(|i| thin(&ring[i], coverage.reach_rad[i]));
        for run in runs(&seen, |a, b| a == b) {
            if let Some(pictures) = seen[run[0]] {
                push_or_widen(&mut gaps, gap(&ring[run[0]], pictures, &run));
            }
        }
    }
    // Where no board is before where only one is.
    gaps.sort_by_key(|gap| matches!(gap, Gap::Between { pictures: 1, .. }));
    gaps
}

/// The same hole in the next ring makes the first one wider.
fn push_or_widen(gaps: &mut Vec<Gap>, gap: Gap) {
    let key = |gap: &Gap| match gap {
        Gap::Between {
            directions,
            pictures,
            ..
        } => Some((directions.clone(), *pictures)),
        _ => None,
    };
    if let Gap::Between {
        from_rad: next,
        to_rad: outer,
        ..
    } = gap
    {
        for earlier in gaps.iter_mut().filter(|earlier| key(earlier) == key(&gap)) {
            if let Gap::Between { to_rad, .. } = earlier
                && *to_rad == next
            {
                *to_rad = outer;
                return;
            }
        }
    }
    gaps.push(gap);
}

/// Runs of neighbours round the circle that are set and alike their first.
fn runs<T>(values: &[Option<T>; 8], alike: impl Fn(&T, &T) -> bool) -> Vec<Vec<usize>> {
    let joins = |a: usize, b: usize| match (&values[a], &values[b]) {
        (Some(a), Some(b)) => alike(a, b),
        _ => false,
    };
    let start = (0..8).find(|i| !joins((i + 7) % 8, *i)).unwrap_or(0);
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for i in (0..8)
        .map(|k| (start + k) % 8)
        .filter(|i| values[*i].is_some())
    {
        let last = runs.last_mut();
        match last.filter(|run| run.last() == Some(&((i + 7) % 8)) && joins(run[0], i)) {
            Some(run) => run.push(i),
            None => runs.push(vec![i]),
        }
    }
    runs
}

/// Gaps of the boards' distances and tilts; a single board has no variety to judge.
fn poses(places: &[Place]) -> Vec<Gap> {
    if places.len() < 3 {
        return Vec::new();
    }
    // A normal's sign says nothing: all towards the first.
    let first = places[0].normal;
    let normals = places
        .iter()
        .map(|p| p.normal * p.normal.dot(&first).signum());
    let normals: Vec<Vector3<f64>> = normals.collect();
    let mean: Vector3<f64> = normals.iter().sum();
    let spread_rad = normals
        .iter()
        .map(|n| angle_between(n, &mean))
        .fold(0.0, f64::max);
    let distances = || places.iter().map(|place| place.distance_mm);
    let nearest_mm = distances().fold(f64::INFINITY, f64::min);
    let farthest_mm = distances().fold(0.0, f64::max);
    let mut gaps = Vec::new();
    if spread_rad < PARALLEL_RAD {
        gaps.push(Gap::Parallel { spread_rad });
    }
    if farthest_mm < ONE_DISTANCE * nearest_mm {
        gaps.push(Gap::OneDistance {
            nearest_mm,
            farthest_mm,
        });
    }
    gaps
}
