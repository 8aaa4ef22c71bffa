//! Fields measured in a tank against predicted ones.

use anyhow::Context;
use serde_json::{Value, json};
use tectum_optics::design::{
    Circle, EdgeField, Explanation, Forward, Reading, Section, edge_pixels, field_from_wall_rad,
    half_angle_from_outer_rad, sensor_clip, wall_from_field,
};
use tectum_optics::{Field, Rig};

use super::args::Args;
use super::given::Given;
use crate::report::{Report, Usage};

/// Sensors that an unknown one is compared with.
const SENSORS: [(&str, [f64; 2]); 4] = [
    ("not clipped", [1.0, 1.0]),
    ("clipped 5:4", [5.0, 4.0]),
    ("clipped 4:3", [4.0, 3.0]),
    ("clipped 16:9", [16.0, 9.0]),
];

/// Compares what was given; nothing if nothing was.
pub fn run(args: &Args, given: &Given) -> anyhow::Result<Option<Report>> {
    let measured = &args.measured;
    let (mut text, mut json) = (String::new(), json!({}));
    if let Some(distance_mm) = measured.wall_distance_mm {
        let widths = [measured.wall_horizontal_mm, measured.wall_design_mm];
        if widths == [None, None] && measured.edge_left.is_none() {
            let message = "--wall-distance-mm goes with --wall-horizontal-mm, --wall-design-mm or \
                           edge pixels";
            return Err(Usage(message.into()).into());
        }
        json["wall_distance_mm"] = json!(distance_mm);
        walls(distance_mm, widths, given, &mut text, &mut json)?;
    }
    if let (Some(left), Some(right), Some(rig)) =
        (measured.edge_left, measured.edge_right, &given.rig)
    {
        let edges = EdgeField::of(rig, left.0, right.0)?;
        let (words, value) = edge_pair(&edges, measured.wall_distance_mm)?;
        text += &words;
        json["edges"] = value;
    }
    if text.is_empty() {
        return Ok(None);
    }
    Ok(Some(Report::new(text, json)))
}

/// Both planes as the wall measures them.
fn walls(
    distance_mm: f64,
    widths_mm: [Option<f64>; 2],
    given: &Given,
    text: &mut String,
    json: &mut Value,
) -> anyhow::Result<()> {
    let mount = Forward::of(&given.eyes)?.mount;
    let zeta = mount.zeta_rad();
    *text += "measured, degrees";
    let mut readings = [None; 2];
    for (i, (name, elevation)) in [("horizontal", 0.0), ("design", zeta)]
        .into_iter()
        .enumerate()
    {
        let Some(width_mm) = widths_mm[i] else {
            continue;
        };
        let circle = Circle::pencil(elevation);
        let outer = field_from_wall_rad(distance_mm, width_mm)?;
        readings[i] = Some(Reading {
            elevation_rad: elevation,
            outer_rad: outer,
        });
        let predicted = Section::of(&given.eyes, &circle).outer_rad();
        let lens = half_angle_from_outer_rad(&mount, elevation, outer)
            .with_context(|| format!("measured on the {name} plane"))?;
        *text += &format!(
            "\n{name:<11} {width_mm} mm on the wall: Eq. 8 {:.4}, predicted {} {:.2}; a circular \
             field of {:.2} would give it",
            outer.to_degrees(),
            if given.wet { "from the eyes" } else { "in air" },
            predicted.to_degrees(),
            2.0 * lens.to_degrees(),
        );
        let mut value = json!({
            "wall_mm": width_mm,
            "measured_deg": outer.to_degrees(),
            "predicted_deg": predicted.to_degrees(),
            "predicted_wall_mm": wall_from_field(distance_mm, predicted),
            "lens_deg": 2.0 * lens.to_degrees(),
        });
        if let Some(rig) = &given.rig {
            *text += &rig_edges(rig, &circle, &mut value)?;
        }
        // A plane that rises ahead meets the wall behind below the fish, farther off.
        if i == 1 && libm::cos(zeta) > 1e-6 {
            let in_plane_mm = distance_mm / libm::cos(zeta);
            let outer = field_from_wall_rad(in_plane_mm, width_mm)?;
            *text += &format!(
                "\n            with the distance in the plane, {in_plane_mm:.0} mm: {:.2}",
                outer.to_degrees()
            );
            value["in_plane"] = json!({
                "distance_mm": in_plane_mm,
                "measured_deg": outer.to_degrees(),
            });
            if let Ok(lens) = half_angle_from_outer_rad(&mount, elevation, outer) {
                *text += &format!("; a field of {:.2} would", 2.0 * lens.to_degrees());
                value["in_plane"]["lens_deg"] = json!(2.0 * lens.to_degrees());
            }
            *text += &format!(
                "\n            the points would lie {:.0} mm below the fish",
                distance_mm * libm::tan(zeta)
            );
        }
        json[name] = value;
    }
    if let [Some(horizontal), Some(design)] = readings
        && !given.wet
    {
        explain(given, horizontal, design, text, json)?;
    }
    Ok(())
}

/// One front fitted on one plane, the other predicted; with several sensors if none is given.
fn explain(
    given: &Given,
    horizontal: Reading,
    design: Reading,
    text: &mut String,
    json: &mut Value,
) -> anyhow::Result<()> {
    let mount = Forward::of(&given.eyes)?.mount;
    let field = &given.eyes.left.field;
    let airs: Vec<(&str, Field)> = match field.circle_rad() {
        Some(half) => SENSORS
            .into_iter()
            .map(|(name, [w, h])| Ok((name, sensor_clip(half, w, h)?)))
            .collect::<anyhow::Result<_>>()?,
        None => vec![("as given", field.clone())],
    };
    *text += "\none front of the lens for both? kappa fitted on one plane, the other predicted";
    let mut list = Vec::new();
    for (sensor, air) in &airs {
        for (name, other_name, known, other) in [
            ("horizontal", "design", horizontal, design),
            ("design", "horizontal", design, horizontal),
        ] {
            let found = Explanation::of(&mount, air, known, other);
            let mut value = json!({ "sensor": sensor, "fitted_on": name });
            *text += &match found {
                Ok(found) => {
                    value["kappa"] = json!(found.front.kappa());
                    value["predicted_deg"] = json!(found.predicted_rad.to_degrees());
                    value["error_deg"] = json!(found.error_rad.to_degrees());
                    format!(
                        "\n  circle {sensor:<12} on {name:<10} kappa {:.4}, then {other_name:<10} \
                         {:.2}, measured {:.2}, error {:+.2}",
                        found.front.kappa(),
                        found.predicted_rad.to_degrees(),
                        other.outer_rad.to_degrees(),
                        found.error_rad.to_degrees()
                    )
                }
                Err(error) => {
                    value["error"] = json!(error.to_string());
                    format!("\n  circle {sensor:<12} on {name:<10} no kappa: {error}")
                }
            };
            list.push(value);
        }
    }
    json["explanations"] = json!(list);
    Ok(())
}

/// Where a calibrated rig has its outer edges on a plane.
fn rig_edges(rig: &Rig, circle: &Circle, value: &mut Value) -> anyhow::Result<String> {
    let Some([left, right]) = edge_pixels(rig, circle)? else {
        return Ok("\n            the rig sees all of this plane: no edge".into());
    };
    value["edge_px"] = json!({ "left": left, "right": right });
    Ok(format!(
        "\n            the rig's edge pixels there: left {:.1},{:.1} right {:.1},{:.1}",
        left[0], left[1], right[0], right[1]
    ))
}

fn edge_pair(edges: &EdgeField, wall_mm: Option<f64>) -> anyhow::Result<(String, Value)> {
    let outer_deg = edges.outer_rad.to_degrees();
    let mut text = format!("\nfield between the edge pixels, by the rig: {outer_deg:.2} degrees");
    let mut value = json!({ "outer_deg": outer_deg });
    if let Some(wall_mm) = wall_mm {
        let [left, right] = edges.on_wall(wall_mm / 1000.0)?.map(|point| point * 1000.0);
        let width_mm = left.y - right.y;
        // Crossed rays would be a field of less than half a turn.
        let by_wall = field_from_wall_rad(wall_mm, width_mm.abs())?;
        text += &format!(
            "\nthey meet the wall {wall_mm} mm behind {:.1} mm apart, {:.1} and {:.1} mm above the \
             origin: Eq. 8 {:.2} degrees",
            width_mm.abs(),
            left.z,
            right.z,
            by_wall.to_degrees()
        );
        value["wall"] = json!({
            "left_mm": [left.x, left.y, left.z],
            "right_mm": [right.x, right.y, right.z],
            "width_mm": width_mm.abs(),
            "equation_8_deg": by_wall.to_degrees(),
        });
    }
    Ok((text, value))
}
