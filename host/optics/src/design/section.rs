//! What both eyes see on one plane.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Area, BothEyes, Circle, EyeView, Mount};

/// Part of a plane on which the same eyes see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins, rad, -pi to pi.
    pub start_rad: f64,
    /// Where it ends, rad, beyond the start by at most a turn.
    pub end_rad: f64,
    /// Who sees it.
    pub area: Area,
}

/// What both eyes see on one plane: segments all the way round.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    segments: Vec<Segment>,
}

/// Samples of a field that is no circle around a plane: 0.25 degrees.
const SAMPLES: u32 = 1440;
/// How well an edge between two samples is found, rad.
const EDGE: f64 = 1e-10;
/// A segment below this is rounding, rad.
const NOTHING: f64 = 1e-11;

impl Section {
    /// The plane of `circle`.
    pub fn of(eyes: &BothEyes, circle: &Circle) -> Self {
        let mut edges = edges(&eyes.left, circle);
        edges.extend(self::edges(&eyes.right, circle));
        edges.sort_by(f64::total_cmp);
        edges.dedup_by(|b, a| *b - *a < NOTHING);
        let area = |angle: f64| eyes.area(&circle.direction(angle));
        let Some(first) = edges.first().copied() else {
            let segments = vec![Segment {
                start_rad: -PI,
                end_rad: PI,
                area: area(0.0),
            }];
            return Self { segments };
        };
        let mut segments: Vec<Segment> = Vec::new();
        let ends = edges[1..].iter().copied().chain([first + TAU]);
        for (start_rad, end_rad) in edges.iter().copied().zip(ends) {
            let area = area((start_rad + end_rad) / 2.0);
            match segments.last_mut() {
                Some(last) if last.area == area => last.end_rad = end_rad,
                _ => segments.push(Segment {
                    start_rad,
                    end_rad,
                    area,
                }),
            }
        }
        Self { segments }
    }

    /// Its segments, in order of their angles; they add up to a turn.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Angle that the left eye sees, rad.
    pub fn left_rad(&self) -> f64 {
        self.total(Area::left)
    }

    /// Angle that the right eye sees, rad.
    pub fn right_rad(&self) -> f64 {
        self.total(Area::right)
    }

    /// Angle that any eye sees, rad.
    pub fn seen_rad(&self) -> f64 {
        self.total(Area::seen)
    }

    /// Angle that both eyes see, rad.
    pub fn both_rad(&self) -> f64 {
        self.total(|area| area == Area::Both)
    }

    /// Overlap ahead, rad; negative where neither eye sees there: the gap's width. Where one eye
    /// alone sees straight ahead, the nearest overlap or gap within a quarter turn counts.
    pub fn front_overlap_rad(&self) -> f64 {
        self.junction_rad(0.0)
    }

    /// Overlap behind, rad, or less the gap, as [`front_overlap_rad`](Self::front_overlap_rad).
    pub fn back_overlap_rad(&self) -> f64 {
        self.junction_rad(PI)
    }

    /// A turn less the gap behind: how far the field reaches around, whether or not there is a gap
    /// ahead, rad. This is what a wall behind the fish measures (Eq. 8).
    pub fn outer_rad(&self) -> f64 {
        TAU + self.back_overlap_rad().min(0.0)
    }

    /// The segments that neither eye sees.
    pub fn blind(&self) -> impl Iterator<Item = Segment> {
        let pieces = self.joined(|area| area == Area::None);
        pieces.into_iter().map(|(start_rad, end_rad)| Segment {
            start_rad,
            end_rad,
            area: Area::None,
        })
    }

    fn total(&self, holds: impl Fn(Area) -> bool) -> f64 {
        let kept = self.segments.iter().filter(|segment| holds(segment.area));
        kept.map(|segment| segment.end_rad - segment.start_rad)
            .sum()
    }

    /// Where both eyes' fields meet near an angle: the overlap, or less the gap.
    fn junction_rad(&self, angle_rad: f64) -> f64 {
        let away = |(start, end): (f64, f64)| {
            let (ahead, width) = ((angle_rad - start).rem_euclid(TAU), end - start);
            match ahead <= width {
                true => 0.0,
                false => (ahead - width).min(TAU - ahead),
            }
        };
        let pieces = |area: Area, sign: f64| {
            let pieces = self.joined(move |other| other == area).into_iter();
            pieces.map(move |piece| (away(piece), sign * (piece.1 - piece.0)))
        };
        pieces(Area::None, -1.0)
            .chain(pieces(Area::Both, 1.0))
            .filter(|(away, _)| *away <= FRAC_PI_2)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(0.0, |(_, signed)| signed)
    }

    /// Pieces on which `holds` is true, neighbours joined, also across the first segment's start.
    fn joined(&self, holds: impl Fn(Area) -> bool) -> Vec<(f64, f64)> {
        let mut pieces: Vec<(f64, f64)> = Vec::new();
        for segment in self.segments.iter().filter(|segment| holds(segment.area)) {
            match pieces.last_mut() {
                Some(last) if last.1 == segment.start_rad => last.1 = segment.end_rad,
                _ => pieces.push((segment.start_rad, segment.end_rad)),
            }
        }
        let origin = self.segments[0].start_rad;
        if let [first, .., last] = pieces[..]
            && first.0 == origin
            && last.1 >= origin + TAU
        {
            pieces.pop();
            pieces[0].0 = last.0 - TAU;
        }
        pieces
    }
}

/// Angles, -pi to pi, at which a plane enters or leaves an eye's field.
fn edges(eye: &EyeView, circle: &Circle) -> Vec<f64> {
    match eye.field.circle_rad() {
        Some(half) => cone_edges(eye, circle, half),
        None => searched_edges(eye, circle),
    }
}

/// The closed form for a cone: `P cos(angle - beta) = cos(half)`, where P is the length of the
/// axis's part in the plane.
fn cone_edges(eye: &EyeView, circle: &Circle, half_rad: f64) -> Vec<f64> {
    let [along, across] = circle.components(&eye.axis());
    let cos = libm::cos(half_rad) / libm::hypot(along, across);
    // A plane at right angles to the axis divides by 0: all or nothing.
    if cos.is_nan() || cos.abs() >= 1.0 {
        return Vec::new();
    }
    let (beta, alpha) = (libm::atan2(across, along), libm::acos(cos));
    vec![wrapped(beta - alpha), wrapped(beta + alpha)]
}

fn searched_edges(eye: &EyeView, circle: &Circle) -> Vec<f64> {
    let sees = |angle: f64| eye.sees(&circle.direction(angle));
    let angle = |i: u32| TAU * f64::from(i) / f64::from(SAMPLES) - PI;
    let mut edges = Vec::new();
    let mut before = sees(angle(0));
    for i in 1..=SAMPLES {
        let now = sees(angle(i));
        if now != before {
            let (mut low, mut high) = (angle(i - 1), angle(i));
            while high - low > EDGE {
                let middle = (low + high) / 2.0;
                match sees(middle) == before {
                    true => low = middle,
                    false => high = middle,
                }
            }
            edges.push((low + high) / 2.0);
        }
        before = now;
    }
    edges
}

/// An angle brought to -pi to pi.
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

/// The closed form for the planes through the left-right axis and the same cone on both sides:
/// each eye sees from `beta - alpha` to `beta + alpha`, to its own side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pencil {
    /// Half the angle that an eye sees on the plane, rad.
    pub alpha_rad: f64,
    /// Angle of the optical axis's projection, rad.
    pub beta_rad: f64,
}

impl Pencil {
    /// On the plane whose front half rises by `elevation_rad`; `None` where an eye sees all of it
    /// or nothing. The design plane has `elevation_rad` = zeta, the horizontal plane 0.
    pub fn of(mount: &Mount, half_rad: f64, elevation_rad: f64) -> Option<Self> {
        let axis = mount.axis(crate::Side::Left);
        let [along, across] = Circle::pencil(elevation_rad).components(&axis);
        let cos = libm::cos(half_rad) / libm::hypot(along, across);
        (cos.abs() <= 1.0).then(|| Self {
            alpha_rad: libm::acos(cos),
            beta_rad: libm::atan2(across, along),
        })
    }

    /// How far both fields reach around, before a turn ends it, rad.
    pub fn outer_rad(&self) -> f64 {
        2.0 * (self.beta_rad + self.alpha_rad)
    }

    /// Overlap ahead, rad; negative for a gap.
    pub fn front_overlap_rad(&self) -> f64 {
        2.0 * (self.alpha_rad - self.beta_rad)
    }
}
