//! The preview of a feed.

use std::net::SocketAddr;
use std::path::Path;

use tectum_bake::{output_map, scales_svg};
use tectum_capture::Operator;
use tectum_capture::preview::{Controls, Fixed, Preview};
use tectum_core::{Eye, Tables};

use super::Feed;
use crate::directions::Answer;

/// Serves a feed, with directions and scales where there is a table. `takes_requests` says that
/// the watch has an operator.
pub fn serve(
    address: SocketAddr,
    feed: &Feed,
    tables: Option<&'static Tables<'static>>,
    takes_requests: bool,
) -> anyhow::Result<Preview> {
    Ok(Preview::serve(
        address,
        Fixed {
            direction: tables.map(|tables| {
                let answer = move |query: &[(String, String)]| direction(tables, query);
                Box::new(answer) as tectum_capture::preview::Answer
            }),
            scales: tables.map(|tables| {
                let draw = move |width_px, step_deg| {
                    scales_svg(&output_map(tables), width_px, step_deg)
                        .map_err(|error| error.to_string())
                };
                Box::new(draw) as tectum_capture::preview::DrawScales
            }),
            controls: controls(feed),
            takes_requests,
            eyes: feed.eyes(),
            // A folder's pictures come each second.
            period_ns: feed
                .period_ns()
                .or((!feed.is_live()).then_some(1_000_000_000)),
        },
    )?)
}

/// Saves in `folder` what the page asks for of a feed.
pub fn operator(folder: &Path, feed: &Feed) -> Operator {
    let ([left, right], [of_left, of_right]) = (feed.eyes(), feed.facts());
    let operator = Operator::new(folder, feed.rate(), false).with_sources([
        left.map(|(name, _)| (name, of_left)),
        right.map(|(name, _)| (name, of_right)),
    ]);
    with_controls(operator, feed)
}

/// What the page sets while a feed is seen is in what is recorded from then on.
#[cfg(feature = "v4l2")]
fn with_controls(operator: Operator, feed: &Feed) -> Operator {
    let [left, right] = feed.sources().map(|eye| eye.map(|(name, _)| name));
    // One camera may give both eyes.
    let names = [left.clone(), right.or(left)];
    operator.with_settings(move || {
        let facts = |name: &String| tectum_capture::device::control_facts(Path::new(name));
        names.each_ref().map(|name| name.as_ref().and_then(facts))
    })
}

#[cfg(not(feature = "v4l2"))]
fn with_controls(operator: Operator, _feed: &Feed) -> Operator {
    operator
}

/// The cameras' own controls, where the eyes are cameras.
#[cfg(feature = "v4l2")]
fn controls(feed: &Feed) -> Option<Box<dyn Controls>> {
    let controls = tectum_capture::device::LiveControls::of(&feed.sources())?;
    Some(Box::new(controls))
}

#[cfg(not(feature = "v4l2"))]
fn controls(_feed: &Feed) -> Option<Box<dyn Controls>> {
    None
}

/// What `tectum lookup --json` prints for a pixel.
fn direction(tables: &Tables<'_>, query: &[(String, String)]) -> Result<String, String> {
    let value = |name: &str| {
        let pair = query.iter().find(|(key, _)| key == name);
        pair.map(|(_, value)| &**value)
    };
    let px = |name| {
        let px: Option<f64> = value(name).and_then(|text| text.parse().ok());
        // As far as `tectum lookup` goes: safely inside 32 bits in Q8.
        px.filter(|px| px.abs() <= 1e6)
            .ok_or_else(|| format!("needed is {name}=POSITION in px"))
    };
    let eye = match value("eye") {
        None => None,
        Some("left") => Some(Eye::Left),
        Some("right") => Some(Eye::Right),
        Some(_) => return Err("eye is left or right".to_owned()),
    };
    let answer = Answer::of_pixel(tables, eye, [px("x")?, px("y")?]);
    answer
        .map(|answer| answer.json().to_string())
        .map_err(|error| error.to_string())
}
