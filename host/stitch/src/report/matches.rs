//! Matches on the pictures, what is left of them, and what parallax leaves at other ranges.

use image::RgbImage;
use tectum_page::picture::jpeg_uri;
use tectum_page::plot::Plot;
use tectum_page::svg::{Path, captioned, drawing, escape, figure};

use super::{ReportInput, Shot};

/// Shots shown; more make a page that nobody scrolls.
const SHOTS: usize = 8;
/// Width of a picture, user units; two stand side by side.
const WIDTH: f64 = 540.0;
const GAP: f64 = 12.0;

pub fn html(input: &ReportInput) -> String {
    if input.shots.is_empty() {
        return String::new();
    }
    let shown = input.shots.iter().filter_map(drawn).take(SHOTS);
    let shown: String = shown.collect();
    format!(
        "<h2 id=\"matches\">Matches</h2>\n<p>Green: used, with its partner joined. Red: set aside.\
         </p>\n{shown}<div class=\"two\">{residuals}{parallax}</div>\n",
        residuals = residuals(input),
        parallax = parallax(input),
    )
}

fn drawn(shot: &Shot) -> Option<String> {
    let pictures = shot.pictures?;
    let scale = |picture: &RgbImage| WIDTH / f64::from(picture.width().max(1));
    let height = pictures
        .map(|picture| f64::from(picture.height()) * scale(picture))
        .into_iter()
        .fold(0.0, f64::max);
    let place = |eye: usize, [x, y]: [f64; 2]| {
        let scale = scale(pictures[eye]);
        [
            (x + 0.5) * scale + eye as f64 * (WIDTH + GAP),
            (y + 0.5) * scale,
        ]
    };
    let mut body = String::new();
    for (eye, picture) in pictures.into_iter().enumerate() {
        // Twice the drawn width, for dense screens.
        let uri = jpeg_uri(picture, 2 * WIDTH as u32)?;
        body += &format!(
            "<image href=\"{uri}\" x=\"{:.0}\" y=\"0\" width=\"{WIDTH}\"/>",
            eye as f64 * (WIDTH + GAP)
        );
    }
    let (mut used, mut out, mut lines) = (Path::default(), Path::default(), Path::default());
    for (pair, left) in shot.matches {
        let ends = [place(0, pair.left_px), place(1, pair.right_px)];
        let dots = if left.is_some() { &mut used } else { &mut out };
        ends.into_iter().for_each(|end| dots.dot(end));
        if left.is_some() {
            lines.lift();
            ends.into_iter().for_each(|end| lines.to(end));
        }
    }
    body += &lines.element("used faint");
    body += &used.element("dot used");
    body += &out.element("dot out");
    let kept = shot
        .matches
        .iter()
        .filter(|(_, left)| left.is_some())
        .count();
    let label = format!("Matches in {}", escape(shot.name));
    Some(captioned(
        &drawing([2.0 * WIDTH + GAP, height], &label, &body),
        &format!(
            "<b>{}</b>: {kept} of {} matches used",
            escape(shot.name),
            shot.matches.len()
        ),
    ))
}

/// How many matches are left with which angle.
fn residuals(input: &ReportInput) -> String {
    let shots = input.shots.iter();
    let mut angles: Vec<f64> = shots
        .flat_map(|shot| shot.matches.iter().filter_map(|(_, left)| *left))
        .map(f64::to_degrees)
        .collect();
    angles.sort_by(f64::total_cmp);
    let Some(most) = angles.last().copied().filter(|most| *most > 0.0) else {
        return String::new();
    };
    const BARS: usize = 24;
    let width = most / BARS as f64;
    let mut counts = [0usize; BARS];
    for angle in &angles {
        counts[((angle / width) as usize).min(BARS - 1)] += 1;
    }
    let top = counts.iter().copied().max().unwrap_or(0) as f64;
    let mut plot = Plot::new([560.0, 300.0], [0.0, most], [0.0, 1.08 * top]);
    for (i, count) in counts.into_iter().enumerate() {
        let low = [i as f64 * width, 0.0];
        let high = [(i + 1) as f64 * width, count as f64];
        let words = format!("{count} matches, {:.3} to {:.3}°", low[0], high[0]);
        plot.bar("bar", low, high, &words);
    }
    let median = angles[angles.len() / 2];
    captioned(
        &plot.finish("Residuals", "angle between the eyes, degrees", "matches"),
        &format!(
            "What is left between the eyes: median {}°, largest {}°.",
            figure(median, 3),
            figure(most, 3)
        ),
    )
}

fn parallax(input: &ReportInput) -> String {
    if input.parallax.is_empty() {
        return String::new();
    }
    let rows = input.parallax.iter().map(|[range_m, rad]| {
        let range = match range_m.is_finite() {
            true => format!("{range_m} m"),
            false => "infinity".to_owned(),
        };
        let left = figure(rad.to_degrees().abs(), 2);
        format!("<tr><td>{range}</td><td>{left}°</td></tr>")
    });
    captioned(
        &format!(
            "<table><tr><th>Range</th><th>Parallax</th></tr>{}</table>",
            rows.collect::<String>()
        ),
        "What parallax leaves between the eyes at other ranges than the stitch distance, at right \
         angles to the line between them.",
    )
}
