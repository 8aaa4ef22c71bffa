//! Residuals as arrows over the picture: each, and their local means.

use super::facts::{Facts, Sighting};
use super::map::Map;
use tectum_page::plot::step;
use tectum_page::svg::{Path, captioned, text};

/// Arrows drawn at most: more cannot be told apart.
const MOST_ARROWS: usize = 4000;
/// Length of an arrow of RMS length, user units.
const USUAL: f64 = 9.0;
/// An outlier's arrow is cut at this length, user units.
const LONGEST: f64 = 60.0;
/// Side of the squares that are averaged over, user units, and the corners that it takes.
const SQUARE: f64 = 28.0;
const LEAST_CORNERS: usize = 4;
/// Means longer than this many times what noise leaves are marked. Noise of RMS s leaves means of
/// n corners an RMS of s / sqrt n, Rayleigh distributed: exp(-2.5^2), 1 in 500, are longer.
const REMARKABLE: f64 = 2.5;

/// Both maps; `usual_px` is the RMS of the residuals.
pub fn html(facts: &Facts, usual_px: f64) -> String {
    let (each, note) = each(facts, usual_px);
    let (means, means_note) = means(facts, usual_px);
    captioned(&each, &note) + &captioned(&means, &means_note)
}

fn each(facts: &Facts, usual_px: f64) -> (String, String) {
    let map = Map::new(facts);
    let factor = step(USUAL / usual_px / map.scale);
    let nth = facts.used().count().div_ceil(MOST_ARROWS).max(1);
    let arrows = |sightings: &[&Sighting]| {
        let mut path = Path::default();
        for one in sightings {
            arrow(
                &mut path,
                map.at(one.seen_px),
                one.fit.residual_px,
                factor * map.scale,
            );
        }
        path
    };
    let used: Vec<&Sighting> = facts.used().step_by(nth).collect();
    let unused: Vec<&Sighting> = facts.unused().take(MOST_ARROWS).collect();
    let note = format!(
        "Seen minus computed at each corner, drawn {factor:.0} times larger. Red: outliers that \
         took no part.{}",
        if nth > 1 {
            format!(" One corner in {nth} is drawn.")
        } else {
            String::new()
        }
    );
    let body = arrows(&used).element("arrow") + &arrows(&unused).element("arrow out");
    (finish(&map, "Residual vectors", factor, &body), note)
}

fn means(facts: &Facts, usual_px: f64) -> (String, String) {
    let map = Map::new(facts);
    let columns = libm::ceil(map.size[0] / SQUARE).max(1.0) as usize;
    let rows = libm::ceil(map.size[1] / SQUARE).max(1.0) as usize;
    let mut sums = vec![(0_usize, [0.0_f64; 2]); columns * rows];
    for sighting in facts.used() {
        let [x, y] = map
            .at(sighting.seen_px)
            .map(|v| (v / SQUARE).max(0.0) as usize);
        let (count, sum) = &mut sums[y.min(rows - 1) * columns + x.min(columns - 1)];
        *count += 1;
        sum[0] += sighting.fit.residual_px[0];
        sum[1] += sighting.fit.residual_px[1];
    }
    let factor = step(2.0 * USUAL / usual_px / map.scale);
    let (mut plain, mut marked) = (Path::default(), Path::default());
    let (mut squares, mut remarkable) = (0, 0);
    for (place, (count, sum)) in sums.iter().enumerate() {
        if *count < LEAST_CORNERS {
            continue;
        }
        let n = *count as f64;
        let mean = sum.map(|v| v / n);
        let long = libm::hypot(mean[0], mean[1]) > REMARKABLE * usual_px / n.sqrt();
        squares += 1;
        remarkable += usize::from(long);
        let middle = [place % columns, place / columns].map(|i| (i as f64 + 0.5) * SQUARE);
        let path = if long { &mut marked } else { &mut plain };
        arrow(path, middle, mean, factor * map.scale);
    }
    let note = format!(
        "Means over squares with {LEAST_CORNERS} corners or more, drawn {factor:.0} times larger: \
         noise averages out, what stays is a lens that the model does not fit or a board that is \
         not flat. Red: {remarkable} of {squares} that noise alone would leave 1 time in 500."
    );
    let body = plain.element("arrow bold") + &marked.element("arrow out");
    (finish(&map, "Mean residual vectors", factor, &body), note)
}

/// The map with its rings below and its scale bar under it.
fn finish(map: &Map, label: &str, factor: f64, arrows: &str) -> String {
    let bar_px = step(40.0 / (factor * map.scale));
    let bar = bar_px * factor * map.scale;
    let y = map.size[1] + 20.0;
    let body = [
        &map.rings(),
        &map.rim().element("rim"),
        arrows,
        &map.labels(),
        &Path::through([[3.0, y], [3.0 + bar, y]]).element("scale"),
        &text("", [bar + 13.0, y + 4.5], &format!("{bar_px} px")),
    ];
    map.finish(label, 32.0, &body.concat())
}

fn arrow(path: &mut Path, from: [f64; 2], residual_px: [f64; 2], factor: f64) {
    let length = libm::hypot(residual_px[0], residual_px[1]) * factor;
    let cut = if length > LONGEST {
        LONGEST / length
    } else {
        1.0
    };
    let [dx, dy] = residual_px.map(|v| v * factor * cut);
    let tip = [from[0] + dx, from[1] + dy];
    path.lift();
    path.to(from);
    path.to(tip);
    // Two barbs, a third of the arrow and at most 3.5 units long.
    let drawn = (length * cut).max(1e-9);
    let size = (drawn / 3.0).min(3.5) / drawn;
    let barb = |side: f64| {
        [
            tip[0] - size * (dx - side * dy),
            tip[1] - size * (dy + side * dx),
        ]
    };
    path.lift();
    path.to(barb(0.5));
    path.to(tip);
    path.to(barb(-0.5));
    path.lift();
}
