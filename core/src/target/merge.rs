//! Which boxes show the same thing.

use heapless::Vec;

use super::sight::Sight;
use super::{AngularSize, PixelBox, Target, unit};
use crate::Direction;
use crate::lookup::functions::sin_cos;
use crate::lookup::vector::dot;

/// What tells boxes apart, whatever order they came in.
type Key = (u8, PixelBox);

/// A pair that may be one: how far apart, and a fixed order among equals.
type PairKey = (u32, Key, Key);

/// Targets of all sights.
pub fn merged<const N: usize>(sights: &Vec<Sight, N>, tolerance: AngularSize) -> Vec<Target, N> {
    let [sine, _] = sin_cos(tolerance.rad().min(core::f32::consts::FRAC_PI_2));
    // Each sight is a group of its own, named by its place; views of a group by its name.
    let mut groups = Vec::<usize, N>::new();
    let mut views = Vec::<u8, N>::new();
    for (place, sight) in sights.iter().enumerate() {
        // As many as sights, so there is room.
        let _ = groups.push(place);
        let _ = views.push(1 << sight.view.index());
    }
    while let Some([kept, joined]) = nearest(sights, &groups, &views, sine) {
        for group in &mut groups {
            if *group == joined {
                *group = kept;
            }
        }
        let more = views.get(joined).copied().unwrap_or(0);
        if let Some(views) = views.get_mut(kept) {
            *views |= more;
        }
    }
    let mut targets = Vec::new();
    for name in 0..sights.len() {
        let members = || {
            let named = sights.iter().zip(&groups);
            named.filter_map(move |(sight, group)| (*group == name).then_some(sight))
        };
        if let Some(target) = combined(members) {
            let _ = targets.push(target);
        }
    }
    sort(&mut targets);
    targets
}

/// The groups of the nearest two sights that may be one.
fn nearest<const N: usize>(
    sights: &Vec<Sight, N>,
    groups: &Vec<usize, N>,
    views: &Vec<u8, N>,
    sine: f32,
) -> Option<[usize; 2]> {
    let mut best: Option<(PairKey, [usize; 2])> = None;
    let all = || sights.iter().zip(groups).enumerate();
    for (place, (a, &group_a)) in all() {
        for (_, (b, &group_b)) in all().skip(place + 1) {
            let views = [group_a, group_b].map(|group| views.get(group).copied().unwrap_or(0));
            if group_a == group_b || views[0] & views[1] != 0 {
                continue;
            }
            // What costs least comes first: most pairs are farther apart than one found before.
            let apart = distance(a.middle, b.middle);
            if best.is_some_and(|((least, ..), _)| least < apart) {
                continue;
            }
            let [key_a, key_b] = [key(a), key(b)];
            let pair = (apart, key_a.min(key_b), key_a.max(key_b));
            if best.is_none_or(|(least, _)| pair < least) && overlap(a, b, sine) {
                best = Some((pair, [group_a, group_b]));
            }
        }
    }
    best.map(|(_, groups)| groups)
}

fn key(sight: &Sight) -> Key {
    (sight.view.index(), sight.pixels)
}

fn overlap(a: &Sight, b: &Sight, sine: f32) -> bool {
    a.holds(b.middle, sine) || b.holds(a.middle, sine)
}

/// Rises with the angle between unit vectors; the bits of floats that are not negative are in order.
fn distance(a: [f32; 3], b: [f32; 3]) -> u32 {
    let chord = [0, 1, 2].map(|i| a[i] - b[i]);
    dot(chord, chord).to_bits()
}

/// One target of sights, at most one a view: mean direction, the greatest sizes, since what an eye's
/// field or a picture's border cuts off makes a box smaller.
fn combined<'a, I: Iterator<Item = &'a Sight>>(members: impl Fn() -> I) -> Option<Target> {
    let mut middle = [0.0; 3];
    let mut views = 0;
    // By view: floats must be added in the same order always.
    for view in 0..3 {
        for sight in members().filter(|sight| sight.view.index() == view) {
            middle = [0, 1, 2].map(|i| middle[i] + sight.middle[i]);
            views |= 1 << view;
        }
    }
    Some(Target {
        direction: Direction::of(unit(middle)),
        width: members().map(|sight| sight.width).max()?,
        height: members().map(|sight| sight.height).max()?,
        solid_angle_q28: members().map(|sight| sight.solid_angle_q28).max()?,
        views,
    })
}

/// By yaw, then pitch, then the rest: insertion, for there are few.
fn sort(targets: &mut [Target]) {
    let key = |target: &Target| {
        let direction = [target.direction.yaw.0, target.direction.pitch.0];
        let size = [target.width.0, target.height.0];
        (direction, size, target.solid_angle_q28, target.views)
    };
    for sorted in 1..targets.len() {
        for at in (0..sorted).rev() {
            let Some([a, b]) = targets.get_mut(at..at + 2) else {
                break;
            };
            if key(a) <= key(b) {
                break;
            }
            core::mem::swap(a, b);
        }
    }
}
