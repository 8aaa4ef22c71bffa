//! Section: standard error of the direction over the field.

use image::{Rgba, RgbaImage};

use super::facts::Facts;
use super::heat::{Grid, colour};
use super::map::Map;
use super::picture::png_uri;
use super::svg::{Path, captioned, figure, text};

/// Samples along the longer side.
const SAMPLES: u32 = 112;
/// Contours of fewer segments are left out.
const SPECK: usize = 24;
/// Room that a label takes on a map, user units.
const LABEL: f64 = 34.0;

/// Standard errors over the picture, as the logarithm of rad.
struct Field {
    grid: Grid,
    /// px between samples.
    pitch_px: f64,
    low: f64,
    high: f64,
    unit: Unit,
}

/// Unit in which a map is told.
#[derive(Clone, Copy)]
struct Unit {
    to_rad: f64,
    name: &'static str,
}

const DEGREES: Unit = Unit {
    to_rad: std::f64::consts::PI / 180.0,
    name: "°",
};
const MILLIDEGREES: Unit = Unit {
    to_rad: DEGREES.to_rad / 1000.0,
    name: " m°",
};

pub fn html(facts: &Facts) -> String {
    let body = match Field::new(facts) {
        Some(field) => captioned(&drawing(facts, &field), &note(&field)),
        None => "<p>There is none to show: the calibration holds no covariance.</p>".into(),
    };
    format!("<section id=\"uncertainty\"><h2>Uncertainty of directions</h2>\n{body}</section>\n")
}

impl Field {
    fn new(facts: &Facts) -> Option<Self> {
        let size = facts
            .input
            .calibration
            .size_px
            .map(|px| f64::from(px.max(1)));
        let pitch_px = size[0].max(size[1]) / f64::from(SAMPLES);
        let [columns, rows] = size.map(|side| (libm::ceil(side / pitch_px) as usize).max(2));
        let pixel = |i: usize| (i as f64 + 0.5) * pitch_px - 0.5;
        let (mut values, mut inside) = (Vec::new(), Vec::new());
        for place in 0..columns * rows {
            let px = [pixel(place % columns), pixel(place / columns)];
            let sigma = (facts.input.angular_sigma_rad)(px).filter(|s| s.is_finite() && *s > 0.0);
            let value = sigma.map_or(f64::NAN, libm::log);
            values.push(value);
            if value.is_finite() && facts.eye.unproject(px).is_ok() {
                inside.push(value);
            }
        }
        inside.sort_by(f64::total_cmp);
        // The ends of the scale leave out what a single pixel at the rim may reach.
        let low = *inside.first()?;
        let high = inside[(inside.len() - 1) * 99 / 100].max(low + 0.05);
        let unit = if libm::exp(low) > DEGREES.to_rad {
            DEGREES
        } else {
            MILLIDEGREES
        };
        Some(Self {
            grid: Grid { columns, values },
            pitch_px,
            low,
            high,
            unit,
        })
    }

    /// Levels of contours: 1, 2 and 5 times powers of ten of the unit.
    fn levels(&self) -> Vec<f64> {
        let powers = (-6..7).flat_map(|p| [1.0, 2.0, 5.0].map(|m| m * libm::pow(10.0, p.into())));
        let inside = |level: &f64| {
            let value = libm::log(level * self.unit.to_rad);
            value > self.low && value < self.high
        };
        powers.filter(inside).collect()
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    fn picture(&self) -> RgbaImage {
        let columns = self.grid.columns;
        let rows = self.grid.values.len() / columns;
        RgbaImage::from_fn(columns as u32, rows as u32, |x, y| {
            let value = self.grid.values[y as usize * columns + x as usize];
            let [r, g, b] = colour(self.share(value));
            Rgba([r, g, b, if value.is_finite() { 255 } else { 0 }])
        })
    }
}

fn drawing(facts: &Facts, field: &Field) -> String {
    let map = Map::new(facts);
    let pitch = field.pitch_px * map.scale;
    let [columns, rows] = [
        field.grid.columns,
        field.grid.values.len() / field.grid.columns,
    ];
    let heat = png_uri(&field.picture()).map(|uri| {
        format!(
            "<g clip-path=\"url(#rim)\"><image href=\"{uri}\" width=\"{:.1}\" height=\"{:.1}\" \
             preserveAspectRatio=\"none\"/></g>",
            columns as f64 * pitch,
            rows as f64 * pitch
        )
    });
    let clip = format!(
        "<clipPath id=\"rim\">{}</clipPath>",
        map.rim().element("clip")
    );
    let (mut lines, mut words, mut taken) = (String::new(), String::new(), Vec::new());
    for level in field.levels() {
        let segments = field.grid.contour(libm::log(level * field.unit.to_rad));
        // A speck about the minimum.
        if segments.len() < SPECK {
            continue;
        }
        let at = |[x, y]: [f64; 2]| [(x + 0.5) * pitch, (y + 0.5) * pitch];
        let mut path = Path::default();
        for [from, to] in &segments {
            path.lift();
            path.to(at(*from));
            path.to(at(*to));
        }
        lines += &path.element("contour");
        let places = segments.iter().map(|[from, _]| at(*from));
        if let Some([x, y]) = label_place(facts, &map, places, &taken) {
            taken.push([x, y]);
            words += &text(
                "mid contour-label",
                [x, y + 4.5],
                &format!("{level}{}", field.unit.name),
            );
        }
    }
    let body = [
        clip,
        heat.unwrap_or_default(),
        format!("<g clip-path=\"url(#rim)\">{lines}</g>"),
        map.reach().element("reach"),
        map.rim().element("rim"),
        words,
        legend(field, map.size),
    ];
    map.finish("Standard error of directions", 62.0, &body.concat())
}

/// Where on a contour its label goes: in the field, clear of other labels, and as far to the upper
/// right of the axis as can be, so that labels stand in a row.
fn label_place(
    facts: &Facts,
    map: &Map,
    places: impl Iterator<Item = [f64; 2]>,
    taken: &[[f64; 2]],
) -> Option<[f64; 2]> {
    let centre = map.at(facts.eye.model.principal_point_px());
    let clear = |p: &[f64; 2]| {
        let sees = |[dx, dy]: [f64; 2]| {
            let px = [p[0] + dx, p[1] + dy].map(|v| v / map.scale - 0.5);
            facts.eye.unproject(px).is_ok()
        };
        let sides = [
            [-LABEL, 0.0],
            [LABEL, 0.0],
            [0.0, -LABEL / 2.0],
            [0.0, LABEL / 2.0],
        ];
        let free = |t: &[f64; 2]| libm::hypot(p[0] - t[0], p[1] - t[1]) > LABEL;
        sides.into_iter().all(sees) && taken.iter().all(free)
    };
    // Cosine of the angle from a direction somewhat above the right.
    let along = |p: &[f64; 2]| {
        let [dx, dy] = [p[0] - centre[0], p[1] - centre[1]];
        (0.8 * dx - 0.6 * dy) / libm::hypot(dx, dy).max(1e-9)
    };
    places
        .filter(clear)
        .max_by(|a, b| along(a).total_cmp(&along(b)))
}

fn legend(field: &Field, [width, height]: [f64; 2]) -> String {
    const STEPS: u32 = 60;
    let left = 30.0;
    let length = width - 2.0 * left;
    let mut legend = String::new();
    for i in 0..STEPS {
        let share = f64::from(i) / f64::from(STEPS);
        let [r, g, b] = colour(share + 0.5 / f64::from(STEPS));
        legend += &format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"12\" \
             shape-rendering=\"crispEdges\" fill=\"rgb({r},{g},{b})\"/>",
            left + share * length,
            height + 14.0,
            length / f64::from(STEPS) + 0.5
        );
    }
    let levels = field.levels();
    let low = libm::exp(field.low) / field.unit.to_rad;
    for level in if levels.is_empty() { vec![low] } else { levels } {
        let x = left + field.share(libm::log(level * field.unit.to_rad)) * length;
        legend += &Path::through([[x, height + 26.0], [x, height + 31.0]]).element("scale thin");
        let words = if low == level {
            figure(level, 3)
        } else {
            level.to_string()
        };
        legend += &text(
            "mid",
            [x, height + 46.0],
            &format!("{words}{}", field.unit.name),
        );
    }
    legend
}

fn note(field: &Field) -> String {
    let told = |value: f64| {
        let millidegrees = libm::exp(value) / MILLIDEGREES.to_rad;
        match millidegrees {
            m if m < 100.0 => figure(m, 2) + " m°",
            m => figure(m / 1000.0, 3) + "°",
        }
    };
    format!(
        "Standard error (one sigma) of the direction of each pixel that the covariance of the \
         lens implies, in thousandths of a degree (m°): {} at best, {} at worst in 99 % of the \
         field. Dashed: up to where boards reach. It holds if the model fits the lens, which the \
         residuals show.",
        told(field.low),
        told(field.high)
    )
}
