//! Boxes in the pictures to targets around the fish.

use std::fmt::Write;
use std::str::FromStr;

use anyhow::{Context, bail};
use serde_json::{Value, json};
use tectum_core::{AngularSize, Eye, Lookup, PixelBox, Tables, Target, Targets, View};

use crate::report::Report;

/// Most boxes of a call.
const MOST: usize = 64;

/// A box in a picture, written `left:X,Y,W,H`.
#[derive(Debug, Clone, Copy)]
pub struct BoxIn {
    view: View,
    pixels: PixelBox,
}

impl FromStr for BoxIn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (name, numbers) = text.split_once(':')?;
            let (view, _) = VIEWS.into_iter().find(|(_, of_view)| *of_view == name)?;
            let numbers: Vec<u16> = numbers
                .split(',')
                .map(|n| n.trim().parse().ok())
                .collect::<Option<_>>()?;
            let [x, y, width, height] = numbers.try_into().ok()?;
            let pixels = PixelBox {
                x,
                y,
                width,
                height,
            };
            (width > 0 && height > 0).then_some(Self { view, pixels })
        };
        read().ok_or_else(|| {
            "needed is left:X,Y,W,H (or right:, stitched:) in whole px: left column, top row, width, \
             height, such as left:100,120,30,20"
                .into()
        })
    }
}

/// The views with their names.
const VIEWS: [(View, &str); 3] = [
    (View::Eye(Eye::Left), "left"),
    (View::Eye(Eye::Right), "right"),
    (View::Stitched, "stitched"),
];

fn name(view: View) -> &'static str {
    let named = VIEWS.into_iter().find(|(of_name, _)| *of_name == view);
    named.map_or("", |(_, name)| name)
}

/// Merges the boxes and reports targets.
pub fn run(
    tables: &Tables<'_>,
    boxes: &[BoxIn],
    tolerance_deg: f64,
    nearest_m: Option<f64>,
) -> anyhow::Result<Report> {
    let mut targets = Targets::<MOST>::new(tables);
    for BoxIn { view, pixels } in boxes {
        targets.add(*view, *pixels).with_context(|| {
            let PixelBox {
                x,
                y,
                width,
                height,
            } = pixels;
            format!("--box {}:{x},{y},{width},{height}", name(*view))
        })?;
    }
    let parallax = nearest_m.map_or(Ok(AngularSize(0)), |m| parallax(tables, m))?;
    let tolerance = AngularSize::from_degrees(tolerance_deg as f32 + parallax.degrees());
    let merged = targets.merged(tolerance);
    let lookup = Lookup::new(tables);
    let mut text = format!(
        "{} boxes, {} targets (one thing within {:.2} deg)\n\
         yaw deg  pitch deg  width deg  height deg  solid sr  seen in\n",
        boxes.len(),
        merged.len(),
        tolerance.degrees()
    );
    for target in &merged {
        let _ = writeln!(
            text,
            "{:>7.2}  {:>9.2}  {:>9.2}  {:>10.2}  {:>8.5}  {}",
            target.direction.yaw.degrees(),
            target.direction.pitch.degrees(),
            target.width.degrees(),
            target.height.degrees(),
            target.solid_angle_sr(),
            seen_in(target).join(", ")
        );
    }
    let json = json!({
        "tolerance_deg": tolerance.degrees(),
        "targets": merged.iter().map(|target| as_json(&lookup, target)).collect::<Vec<_>>(),
    });
    Ok(Report::new(text, json))
}

fn seen_in(target: &Target) -> Vec<&'static str> {
    let seen = VIEWS
        .into_iter()
        .filter(|(view, _)| target.is_seen_in(*view));
    seen.map(|(_, name)| name).collect()
}

fn as_json(lookup: &Lookup<'_>, target: &Target) -> Value {
    let pixel = lookup.pixel_of_direction(target.direction);
    let [x, y] = [0, 1].map(|i| pixel.map(|q8| f64::from(q8[i]) / 256.0));
    json!({
        "yaw_deg": target.direction.yaw.degrees(),
        "pitch_deg": target.direction.pitch.degrees(),
        "width_deg": target.width.degrees(),
        "height_deg": target.height.degrees(),
        "solid_angle_sr": target.solid_angle_sr(),
        "seen_in": seen_in(target),
        "x": x,
        "y": y,
    })
}

/// How far apart both eyes see what is `nearest_m` away.
fn parallax(tables: &Tables<'_>, nearest_m: f64) -> anyhow::Result<AngularSize> {
    let stated = |line: &str| line.strip_prefix("stitch_distance_m = ")?.parse().ok();
    let distance_m: f64 = tables
        .metadata()
        .lines()
        .find_map(stated)
        .filter(|m: &f64| m.is_finite())
        .context(
            "--nearest needs a table that is exact at a finite distance and says so: give the \
             parallax with --tolerance",
        )?;
    if nearest_m.is_nan() || nearest_m <= 0.0 || nearest_m > distance_m {
        bail!("--nearest {nearest_m} is not allowed: above 0, at most the table's {distance_m} m");
    }
    let range = (nearest_m / distance_m) as f32;
    Ok(Targets::<MOST>::parallax(tables, range))
}
