//! Section: what part of the field boards cover.

use std::f64::consts::{FRAC_PI_8, PI};

use super::coverage::{Cell, Direction, Place};
use super::facts::Facts;
use super::map::Map;
use tectum_page::picture::jpeg_uri;
use tectum_page::plot::Plot;
use tectum_page::svg::{Path, captioned, drawing, escape, text};

/// Radius of the polar chart and its drawing's sides, user units.
const RADIUS: f64 = 200.0;
const CHART: [f64; 2] = [560.0, 460.0];
/// Room for the key under it, user units.
const KEY: f64 = 30.0;

pub fn html(facts: &Facts) -> String {
    let gaps = &facts.coverage.gaps;
    let missing: String = gaps
        .iter()
        .map(|gap| format!("<li>{}</li>", escape(&gap.to_string())))
        .collect();
    let missing = match missing.is_empty() {
        true => {
            "<p>Nothing is missing: every part of the field is in two pictures or more.</p>".into()
        }
        false => format!("<p>What is missing, as seen in the picture:</p><ul>{missing}</ul>"),
    };
    format!(
        "<section id=\"coverage\"><h2>Coverage of the field</h2>\n{missing}\n\
         <div class=\"two\">{}{}</div>\n<div class=\"two\">{}{}</div></section>\n",
        captioned(
            &corners(facts),
            "Corners that took part, over the picture with most of them. Rings every 15 degrees \
             off axis; the thick line is the edge of what lens and sensor show.",
        ),
        captioned(
            &chart(&facts.coverage.cells),
            "The same by rings and sectors, up is up in the picture: corners in each cell, \
             coloured by the pictures that show a board there.",
        ),
        captioned(
            &places(facts, "distance, mm", |place| place.distance_mm),
            "Distance of each board: near and far ones together tell where the rays meet.",
        ),
        captioned(
            &places(facts, "tilt, degrees", |place| place.tilt_rad.to_degrees()),
            "Tilt of each board against the line of sight: tilted ones fix the scale of the lens.",
        ),
    )
}

fn corners(facts: &Facts) -> String {
    let map = Map::new(facts);
    let shown = facts.pictures.iter().filter(|p| p.given.picture.is_some());
    let fullest = shown.max_by_key(|p| p.used().count());
    let background = fullest.and_then(|p| jpeg_uri(p.given.picture?, 800));
    let background = background.map(|uri| {
        format!(
            "<image class=\"faint\" href=\"{uri}\" width=\"{:.1}\" height=\"{:.1}\" \
             preserveAspectRatio=\"none\"/>",
            map.size[0], map.size[1]
        )
    });
    let dots = Path::dots(facts.used().map(|s| map.at(s.seen_px)));
    let body = [
        background.unwrap_or_default(),
        map.rim().element("rim"),
        dots.element("dot seen"),
        map.rings(),
        map.labels(),
    ];
    map.finish("Corners over the picture", 0.0, &body.concat())
}

/// Outline of a cell in the chart, by radii and the sector's middle.
fn outline([inner, outer]: [f64; 2], direction: Option<Direction>) -> Path {
    let (middle, half) = direction.map_or((0.0, PI), |d| (d.azimuth_rad(), FRAC_PI_8));
    let steps = || (0..=24).map(|i| middle + half * (f64::from(i) / 12.0 - 1.0));
    let outside = steps().map(|a| at(outer, a));
    let inside = steps().rev().map(|a| at(inner, a)).filter(|_| inner > 0.0);
    Path::through(outside.chain(inside))
}

fn at(radius: f64, azimuth: f64) -> [f64; 2] {
    let [x, y] = CHART.map(|side| side / 2.0);
    [
        x + radius * libm::cos(azimuth),
        y + radius * libm::sin(azimuth),
    ]
}

fn chart(cells: &[Cell]) -> String {
    let end = cells.last().map_or(1.0, |cell| cell.to_rad);
    let radius = |theta: f64| RADIUS * theta / end;
    let (mut areas, mut words) = (String::new(), String::new());
    for cell in cells {
        let class = match (cell.visible, cell.pictures) {
            (false, 0) => "cell unseen",
            (_, 0) => "cell none",
            (_, 1) => "cell one",
            (_, 2..=3) => "cell some",
            _ => "cell many",
        };
        let [inner, outer] = [radius(cell.from_rad), radius(cell.to_rad)];
        areas += &format!(
            "<g>{}<title>{} corners in {} pictures</title></g>",
            outline([inner, outer], cell.direction).element(class),
            cell.corners,
            cell.pictures
        );
        let middle = match cell.direction {
            Some(direction) => at((inner + outer) / 2.0, direction.azimuth_rad()),
            None => at(0.0, 0.0),
        };
        if cell.visible || cell.pictures > 0 {
            words += &text(
                "mid",
                [middle[0], middle[1] + 4.5],
                &cell.corners.to_string(),
            );
        }
        let degrees = libm::round(cell.to_rad.to_degrees());
        let clear = end - cell.to_rad > 10f64.to_radians();
        let told = degrees % 30.0 == 0.0 && clear || cell.to_rad == end;
        if told && cell.direction == Some(Direction::Right) {
            let degrees = format!("{degrees:.0}°");
            let [x, y] = at(outer, -FRAC_PI_8);
            words += &text("mid halo dim small", [x, y + 4.0], &degrees);
        }
    }
    for direction in Direction::ALL {
        let azimuth = direction.azimuth_rad();
        let [x, y] = at(RADIUS + 10.0, azimuth);
        let side = match libm::cos(azimuth) {
            c if c > 0.1 => "dim",
            c if c < -0.1 => "end dim",
            _ => "mid dim",
        };
        words += &text(
            side,
            [x, y + 4.0 + 5.0 * libm::sin(azimuth)],
            &direction.to_string(),
        );
    }
    let key = [
        ("none", "none"),
        ("one", "1"),
        ("some", "2–3"),
        ("many", "4 or more pictures"),
    ];
    let mut x = 100.0;
    let y = CHART[1] + KEY / 2.0;
    for (class, name) in key {
        words += &format!(
            "<rect class=\"cell {class}\" x=\"{x:.0}\" y=\"{:.0}\" width=\"16\" height=\"16\"/>",
            y - 12.5
        );
        words += &text("", [x + 22.0, y], name);
        x += 80.0;
    }
    let size = [CHART[0], CHART[1] + KEY];
    drawing(size, "Corners by ring and sector", &(areas + &words))
}

/// A property of the boards against their angle off axis.
fn places(facts: &Facts, name: &str, value: impl Fn(&Place) -> f64) -> String {
    let accepted = facts.pictures.iter().filter(|picture| picture.accepted());
    let places = accepted.filter_map(|picture| picture.place);
    let points: Vec<[f64; 2]> = places
        .map(|place| [place.off_axis_rad.to_degrees(), value(&place)])
        .collect();
    let top = points.iter().map(|p| p[1]).fold(0.0, f64::max);
    let limit = facts.coverage.limit_rad.iter().copied().fold(0.0, f64::max);
    let mut plot = Plot::new([560.0, 220.0], [0.0, limit.to_degrees()], [0.0, 1.08 * top]);
    plot.dots("dot board", points);
    plot.finish(name, "middle of the board off axis, degrees", name)
}
