//! The lens along its radius: residuals, and the section with the curve itself.

use nalgebra::Vector3;

use super::facts::Facts;
use super::residuals::MOST_POINTS;
use tectum_page::plot::{Plot, ticks};
use tectum_page::svg::{captioned, degrees, figure};

/// Half-width of the running mean, degrees.
const HALF_WIDTH_DEG: f64 = 4.0;

/// Radial and tangential residuals against the angle off axis; `usual_px` is their RMS.
pub fn residuals(facts: &Facts, usual_px: f64) -> String {
    let [radial, tangential] = components(facts);
    let nth = radial.len().div_ceil(MOST_POINTS).max(1);
    let end = limit_deg(facts);
    let scatter = |values: &[[f64; 2]], name: &str| {
        let range = 3.0 * usual_px;
        let mut plot = Plot::new([560.0, 300.0], [0.0, end], [-range, range]);
        plot.dots("dot cloud", values.iter().step_by(nth).copied());
        plot.line("zero", [[0.0, 0.0], [end, 0.0]]);
        plot.line("mean", running_mean(values, end));
        plot.finish(name, "off axis, degrees", name)
    };
    captioned(
        &scatter(&radial, "radial, px"),
        "Radial part of the residuals, positive outwards. Where the running mean (line, 8 degrees \
         wide) leaves zero, the model does not fit the lens at that radius.",
    ) + &captioned(
        &scatter(&tangential, "tangential, px"),
        "Tangential part, positive clockwise as seen in the picture. Where only noise is left it \
         is as large as the radial part.",
    )
}

/// `[degrees off axis, px]` of the radial and of the tangential component.
fn components(facts: &Facts) -> [Vec<[f64; 2]>; 2] {
    let centre = facts.eye.model.principal_point_px();
    let mut components = [Vec::new(), Vec::new()];
    for sighting in facts.used() {
        let Some(theta) = sighting.off_axis_rad else {
            continue;
        };
        let [dx, dy] = [0, 1].map(|i| sighting.seen_px[i] - centre[i]);
        let r = libm::hypot(dx, dy);
        if r > 0.0 {
            let [x, y] = sighting.fit.residual_px;
            components[0].push([theta.to_degrees(), (x * dx + y * dy) / r]);
            components[1].push([theta.to_degrees(), (y * dx - x * dy) / r]);
        }
    }
    components
}

/// Mean of `[angle, value]` about every degree or so, in degrees; none where there are few.
fn running_mean(values: &[[f64; 2]], end: f64) -> Vec<[f64; 2]> {
    const LEAST: usize = 10;
    let mean = |place: f64| {
        let near = values
            .iter()
            .filter(|v| (v[0] - place).abs() <= HALF_WIDTH_DEG);
        let (count, sum) = near.fold((0, 0.0), |(n, sum), v| (n + 1, sum + v[1]));
        if count < LEAST {
            f64::NAN
        } else {
            sum / count as f64
        }
    };
    let places = ticks([0.0, end], 80).into_iter();
    places.map(|place| [place, mean(place)]).collect()
}

fn limit_deg(facts: &Facts) -> f64 {
    let limits = facts.coverage.limit_rad.iter().copied();
    limits.fold(0.0, f64::max).to_degrees()
}

/// Distance from the principal point against the angle, mean of four azimuths, px.
fn radius_px(facts: &Facts, theta: f64) -> f64 {
    let centre = facts.eye.model.principal_point_px();
    let (sin, cos) = (libm::sin(theta), libm::cos(theta));
    let azimuths = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let radii = azimuths.map(|[x, y]| {
        let pixel = facts
            .eye
            .model
            .project(&Vector3::new(sin * x, sin * y, cos));
        pixel.map_or(f64::NAN, |[x, y]| libm::hypot(x - centre[0], y - centre[1]))
    });
    radii.iter().sum::<f64>() / 4.0
}

/// The section with the lens's curve.
pub fn html(facts: &Facts) -> String {
    let end = limit_deg(facts);
    // Slope at the axis: a tenth of a degree is straight to 1e-6 for any lens.
    let focal = radius_px(facts, 0.1_f64.to_radians()) / 0.1_f64.to_radians();
    let equidistant = |deg: f64| focal * deg.to_radians();
    let angles: Vec<f64> = (0..=120).map(|i| end * f64::from(i) / 120.0).collect();
    let lens: Vec<[f64; 2]> = angles
        .iter()
        .map(|a| [*a, radius_px(facts, a.to_radians())])
        .collect();
    let difference: Vec<[f64; 2]> = lens
        .iter()
        .map(|[a, r]| [*a, r - equidistant(*a)])
        .collect();

    let radii = lens.iter().map(|p| p[1]).chain([equidistant(end)]);
    let top = 1.08 * radii.filter(|r| r.is_finite()).fold(0.0, f64::max);
    let mut plot = plot(facts, [0.0, top]);
    plot.line("equidistant", angles.iter().map(|a| [*a, equidistant(*a)]));
    plot.line("mean", lens.iter().copied());
    let curve = plot.finish("Radius against angle", "off axis, degrees", "radius, px");

    let finite = || difference.iter().map(|p| p[1]).filter(|d| d.is_finite());
    let (low, high) = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
    let margin = 0.08 * (high - low).max(1e-3);
    let mut apart = self::plot(facts, [low - margin, high + margin]);
    apart.line("zero", [[0.0, 0.0], [end, 0.0]]);
    apart.line("mean", difference.iter().copied());
    let apart = apart.finish("Difference", "off axis, degrees", "beyond equidistant, px");

    let last = difference.iter().rev().find(|p| p[1].is_finite());
    let [angle, most] = last.copied().unwrap_or([f64::NAN; 2]);
    format!(
        "<section id=\"lens\"><h2>The lens</h2>\n<div class=\"two\">{}{}</div></section>\n",
        captioned(
            &curve,
            &format!(
                "Distance from the distortion centre against the angle off axis; dashed: an \
                 equidistant lens of the same {} px to a radian at the axis. Shaded, if anything: \
                 beyond the outermost corner, where the lens is extrapolated.",
                figure(focal, 2)
            ),
        ),
        captioned(
            &apart,
            &format!(
                "The difference of the two: {} px at {}.",
                figure(most, 2),
                degrees(angle.to_radians())
            ),
        ),
    )
}

/// A plot over the field, shaded where no corner is.
fn plot(facts: &Facts, y: [f64; 2]) -> Plot {
    let end = limit_deg(facts);
    let covered = facts.input.calibration.field_rad.to_degrees();
    let mut plot = Plot::new([560.0, 320.0], [0.0, end], y);
    if covered < end {
        plot.bar(
            "beyond",
            [covered, y[0]],
            [end, y[1]],
            "beyond the outermost corner",
        );
    }
    plot
}
