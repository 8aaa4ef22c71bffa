//! Section: standard error of the direction over the field.

use super::AngularSigma;
use super::facts::Facts;
use super::heat::colour;
use super::map::Map;
use super::sigma::{MILLIDEGREES, SigmaMap};
use tectum_page::picture::png_uri;
use tectum_page::svg::{Path, captioned, figure, text};

/// Contours of fewer segments are left out.
const SPECK: usize = 24;
/// Room that a label takes on a map, user units.
const LABEL: f64 = 34.0;

/// How the own frame's and the rotation-free standard errors are told.
const OWN_FRAME: &str = "of the ray through each pixel in the camera's own frame";
const ROTATION_FREE: &str = "with the best common rotation of all rays taken off, as in a rig \
                             that finds the rotation of each eye by itself";

pub fn html(facts: &Facts) -> String {
    let own = figure_of(facts, "own-frame", facts.input.angular_sigma_rad, OWN_FRAME);
    let free = facts.input.rotation_free_sigma_rad;
    let free = free.and_then(|sigma| figure_of(facts, "rotation-free", sigma, ROTATION_FREE));
    let which = if free.is_some() { "the second" } else { "this" };
    let body = match (own, free) {
        (Some(own), Some(free)) => format!("<div class=\"two\">{own}{free}</div>"),
        (Some(one), None) | (None, Some(one)) => format!("<div class=\"one\">{one}</div>"),
        _ => "<p>There is none to show: the calibration holds no covariance.</p>".into(),
    };
    format!(
        "<section id=\"uncertainty\"><h2>Uncertainty of directions</h2>\n{body}\
         <p class=\"dim\">What the corners' noise and the pictures' scatter imply, with what a lens of \
         more freedom shows the chosen one to leave out. How far the calibration can be trusted \
         is read from {which} map. Dashed: up to where boards reach.</p></section>\n"
    )
}

fn figure_of(facts: &Facts, id: &str, sigma_rad: &AngularSigma, what: &str) -> Option<String> {
    let field = SigmaMap::new(facts, sigma_rad)?;
    Some(captioned(&drawing(facts, &field, id), &note(&field, what)))
}

fn drawing(facts: &Facts, field: &SigmaMap, id: &str) -> String {
    let map = Map::new(facts);
    let pitch = field.pitch_px * map.scale;
    let [columns, rows] = [
        field.grid.columns,
        field.grid.values.len() / field.grid.columns,
    ];
    let heat = png_uri(&field.picture()).map(|uri| {
        format!(
            "<g clip-path=\"url(#{id})\"><image href=\"{uri}\" width=\"{:.1}\" height=\"{:.1}\" \
             preserveAspectRatio=\"none\"/></g>",
            columns as f64 * pitch,
            rows as f64 * pitch
        )
    });
    let clip = format!(
        "<clipPath id=\"{id}\">{}</clipPath>",
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
        format!("<g clip-path=\"url(#{id})\">{lines}</g>"),
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

fn legend(field: &SigmaMap, [width, height]: [f64; 2]) -> String {
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

fn note(field: &SigmaMap, what: &str) -> String {
    let told = |value: f64| {
        let millidegrees = libm::exp(value) / MILLIDEGREES.to_rad;
        match millidegrees {
            m if m < 100.0 => figure(m, 2) + " m°",
            m => figure(m / 1000.0, 3) + "°",
        }
    };
    format!(
        "Standard error (RMS angle to the true ray) {what}, in thousandths of a degree (m°) or \
         degrees: {} at best, {} at worst in 99 % of the field.",
        told(field.low),
        told(field.high)
    )
}
