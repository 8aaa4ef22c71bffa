//! What a mount sees.

use serde_json::{Value, json};
use tectum_optics::convention::yaw_pitch;
use tectum_optics::design::{BothEyes, Circle, Forward, Port, Section};
use tectum_optics::{FrontElement, FrontElementError};

use super::args::{Args, MediumName};
use super::given::Given;
use super::pictures;
use crate::report::{Report, Usage};

/// A plane with a name and its section.
pub struct Plane {
    /// In words.
    pub name: String,
    /// For files.
    pub file: String,
    /// The plane.
    pub circle: Circle,
    /// Extra keys for scripts.
    key: Value,
}

/// Computes, draws and reports.
pub fn run(args: &Args, given: &Given) -> anyhow::Result<Report> {
    let air = Forward::of(&given.eyes)?;
    let wet = wet_forms(args, given)?;
    let shown = shown_eyes(args, given)?;
    let planes = planes(args)?;
    let files = match &args.pictures {
        Some(folder) => pictures::write(folder, &shown, &Forward::of(&shown)?, &planes)?,
        None => Vec::new(),
    };
    let mut text = head(&air, given);
    text += &table(&air, &wet, args, given);
    text += &extra_planes(args, given, &shown, &planes);
    text += &zones(&air);
    if !files.is_empty() {
        let folder = args
            .pictures
            .as_ref()
            .map(|folder| folder.display().to_string());
        let words = if given.wet {
            "water"
        } else {
            args.medium.words()
        };
        text += &format!(
            "\npictures ({words}) in {}: {}",
            folder.unwrap_or_default(),
            files.join(" ")
        );
    }
    let mut json = figures(&air);
    json["medium"] = json!(if given.wet { "water" } else { "air" });
    json["theta_deg"] = json!(air.theta_rad.to_degrees());
    json["blind_zones"] = zones_json(&air);
    json["planes"] = planes
        .iter()
        .map(|plane| plane_json(plane, &shown))
        .collect();
    let water = wet.iter().map(|(name, form)| {
        let mut value = form.as_ref().map_or(Value::Null, figures);
        if *name == MediumName::Bare && form.is_some() {
            value["kappa"] = json!(args.kappa);
        }
        (key(*name).to_owned(), value)
    });
    json["water"] = match given.wet {
        true => Value::Null,
        false => Value::Object(water.collect()),
    };
    json["files"] = json!(files);
    Ok(Report::new(text, json))
}

fn key(name: MediumName) -> &'static str {
    match name {
        MediumName::Air => "air",
        MediumName::FlatPort => "flat_port",
        MediumName::Dome => "dome",
        MediumName::Bare => "bare",
    }
}

/// The eyes in the medium that is asked for.
fn shown_eyes(args: &Args, given: &Given) -> anyhow::Result<BothEyes> {
    match args.medium.port(args.kappa)? {
        Some(_) if given.wet => Err(Usage(
            "the eyes were calibrated in water: --medium is for eyes in air".into(),
        )
        .into()),
        Some(port) => Ok(given.eyes.in_water(port)?),
        None => Ok(given.eyes.clone()),
    }
}

/// In water: behind a flat port, in a dome, bare; nothing for a lens too wide for the front.
fn wet_forms(args: &Args, given: &Given) -> anyhow::Result<Vec<(MediumName, Option<Forward>)>> {
    let front = FrontElement::new(args.kappa)?;
    let ports = [
        (MediumName::Dome, Port::Dome),
        (MediumName::FlatPort, Port::Flat),
        (MediumName::Bare, Port::Bare(front)),
    ];
    let mut forms = Vec::new();
    for (name, port) in ports.into_iter().filter(|_| !given.wet) {
        let form = match given.eyes.in_water(port) {
            Ok(eyes) => Some(Forward::of(&eyes)?),
            Err(tectum_optics::design::DesignError::Front(FrontElementError::Grazing {
                ..
            })) if args.medium != MediumName::Bare => None,
            Err(error) => return Err(error.into()),
        };
        forms.push((name, form));
    }
    Ok(forms)
}

/// Planes: the horizontal one and the design plane are always there.
fn planes(args: &Args) -> anyhow::Result<Vec<Plane>> {
    let pencil = args.plane.iter().map(|deg| {
        Ok(Plane {
            name: format!("plane through the left-right axis, {deg} degrees up ahead"),
            file: format!("plane-{deg}"),
            circle: Circle::pencil(deg.to_radians()),
            key: json!({ "elevation_deg": deg }),
        })
    });
    let any = args.plane_normal.iter().enumerate().map(|(i, normal)| {
        let [x, y, z] = [normal.0.x, normal.0.y, normal.0.z];
        Ok(Plane {
            name: format!("plane with normal {x}, {y}, {z}"),
            file: format!("plane-normal-{}", i + 1),
            circle: Circle::of_normal(&normal.0)?,
            key: json!({ "normal": [x, y, z] }),
        })
    });
    pencil.chain(any).collect()
}

/// The figures of one medium for scripts.
pub fn figures(forward: &Forward) -> Value {
    let deg = f64::to_degrees;
    let paper = &forward.paper;
    let [horizontal_margin, design_margin] = forward.margins_rad.map(deg);
    let shares = &forward.shares;
    json!({
        "psi_deg": deg(forward.mount.psi_rad()),
        "tau_deg": deg(forward.mount.tau_rad()),
        "theta_deg": deg(forward.theta_rad),
        "xi_deg": deg(forward.mount.xi_rad()),
        "zeta_deg": deg(forward.mount.zeta_rad()),
        "between_axes_deg": deg(forward.between_axes_rad),
        "phi_deg": deg(forward.phi_rad()),
        "theta_total_deg": deg(forward.theta_total_rad()),
        "paper": {
            "xi_deg": deg(paper.xi_rad),
            "zeta_deg": deg(paper.zeta_rad),
            "phi_deg": deg(paper.phi_rad),
            "theta_total_deg": deg(paper.theta_total_rad),
        },
        "design": section(&forward.design),
        "horizontal": section(&forward.horizontal),
        "sphere": {
            "seen": shares.seen(),
            "both": shares.both,
            "left_only": shares.left_only,
            "right_only": shares.right_only,
            "blind": shares.blind(),
        },
        "margins": { "horizontal_deg": horizontal_margin, "design_deg": design_margin },
    })
}

fn section(section: &Section) -> Value {
    let deg = f64::to_degrees;
    let blind = section
        .blind()
        .map(|gap| json!({ "from_deg": deg(gap.start_rad), "to_deg": deg(gap.end_rad) }));
    json!({
        "outer_deg": deg(section.outer_rad()),
        "front_overlap_deg": deg(section.front_overlap_rad()),
        "back_overlap_deg": deg(section.back_overlap_rad()),
        "seen_deg": deg(section.seen_rad()),
        "both_deg": deg(section.both_rad()),
        "left_deg": deg(section.left_rad()),
        "right_deg": deg(section.right_rad()),
        "blind": blind.collect::<Vec<_>>(),
    })
}

fn plane_json(plane: &Plane, eyes: &BothEyes) -> Value {
    let mut value = section(&Section::of(eyes, &plane.circle));
    if let (Some(value), Some(key)) = (value.as_object_mut(), plane.key.as_object()) {
        value.extend(key.clone());
    }
    value
}

fn zones_json(forward: &Forward) -> Value {
    let zone = |zone: &tectum_optics::design::BlindZone| {
        let (yaw, pitch) = yaw_pitch(&zone.direction);
        json!({
            "yaw_deg": yaw.to_degrees(),
            "pitch_deg": pitch.to_degrees(),
            "solid_angle_sr": zone.solid_angle_sr,
            "share": zone.solid_angle_sr / SPHERE_SR,
            "reach_deg": zone.reach_rad.to_degrees(),
        })
    };
    forward.blind_zones.iter().map(zone).collect()
}

const SPHERE_SR: f64 = 4.0 * std::f64::consts::PI;

fn head(forward: &Forward, given: &Given) -> String {
    let deg = f64::to_degrees;
    let (mount, paper) = (&forward.mount, &forward.paper);
    let of = match &given.rig {
        Some(rig) => format!("rig {}, nearest mount ", rig.name),
        None => String::new(),
    };
    format!(
        "{of}psi {:.2}, tau {:.2}, lens {:.2} degrees\n\
         \n{:<30}{:>10}{:>14}\n\
         {:<30}{:>10.2}{:>14.2}\n{:<30}{:>10.2}{:>14.2}\n{:<30}{:>10.2}{:>14.2}\n\
         {:<30}{:>10.2}{:>14.2}\n{:<30}{:>10.2}\n\
         The paper's phi and Theta hold for tau 0 only.\n",
        deg(mount.psi_rad()),
        deg(mount.tau_rad()),
        deg(forward.theta_rad),
        "degrees",
        "exact",
        "paper's form",
        "xi, overlap in the image",
        deg(mount.xi_rad()),
        deg(paper.xi_rad),
        "zeta, rise of design plane",
        deg(mount.zeta_rad()),
        deg(paper.zeta_rad),
        "phi, overlap on it",
        deg(forward.phi_rad()),
        deg(paper.phi_rad),
        "Theta, whole field on it",
        deg(forward.theta_total_rad()),
        deg(paper.theta_total_rad),
        "between optical axes",
        deg(forward.between_axes_rad),
    )
}

/// Media side by side.
fn table(
    air: &Forward,
    wet: &[(MediumName, Option<Forward>)],
    args: &Args,
    given: &Given,
) -> String {
    let mut columns = vec![(
        if given.wet { "water" } else { "air" }.to_owned(),
        Some(air),
    )];
    for (name, form) in wet {
        let title = match name {
            MediumName::Air => "air".into(),
            MediumName::Dome => "dome".into(),
            MediumName::FlatPort => "flat port".into(),
            MediumName::Bare => format!("bare {}", args.kappa),
        };
        columns.push((title, form.as_ref()));
    }
    type Row = (&'static str, fn(&Forward) -> f64);
    let rows: [Row; 12] = [
        ("lens", |f| f.theta_rad.to_degrees()),
        ("design plane: whole field", |f| {
            f.theta_total_rad().to_degrees()
        }),
        ("  overlap", |f| f.phi_rad().to_degrees()),
        ("horizontal: reaches around", |f| {
            f.horizontal.outer_rad().to_degrees()
        }),
        ("  overlap ahead", |f| {
            f.horizontal.front_overlap_rad().to_degrees()
        }),
        ("  overlap behind", |f| {
            f.horizontal.back_overlap_rad().to_degrees()
        }),
        ("  seen", |f| f.horizontal.seen_rad().to_degrees()),
        ("sphere: seen, %", |f| 100.0 * f.shares.seen()),
        ("  by both, %", |f| 100.0 * f.shares.both),
        ("  blind, %", |f| 100.0 * f.shares.blind()),
        ("lens may lose: horizontal", |f| {
            f.margins_rad[0].to_degrees()
        }),
        ("  design plane", |f| f.margins_rad[1].to_degrees()),
    ];
    let mut text = format!("\n{:<30}", "degrees");
    for (title, _) in &columns {
        text += &format!("{title:>12}");
    }
    for (name, of) in rows {
        text += &format!("\n{name:<30}");
        for (_, form) in &columns {
            text += &match form {
                Some(form) => format!("{:>12.2}", of(form)),
                None => format!("{:>12}", "-"),
            };
        }
    }
    if wet.iter().any(|(_, form)| form.is_none()) {
        text += "\n-: this front shows no rays so far off the axis, see --kappa";
    }
    text +=
        "\nA negative overlap is a gap. A lens that loses more than the margin opens one ahead.\n";
    text
}

fn extra_planes(args: &Args, given: &Given, eyes: &BothEyes, planes: &[Plane]) -> String {
    let medium = if given.wet {
        "water"
    } else {
        args.medium.words()
    };
    let line = |plane: &Plane| {
        let section = Section::of(eyes, &plane.circle);
        format!(
            "\n{} ({medium}): seen {:.2}, reaches around {:.2}, overlap ahead {:.2}, behind {:.2}",
            plane.name,
            section.seen_rad().to_degrees(),
            section.outer_rad().to_degrees(),
            section.front_overlap_rad().to_degrees(),
            section.back_overlap_rad().to_degrees()
        )
    };
    let lines: String = planes.iter().map(line).collect();
    if lines.is_empty() {
        lines
    } else {
        lines + "\n"
    }
}

fn zones(forward: &Forward) -> String {
    if forward.blind_zones.is_empty() {
        return "\nno blind zone".into();
    }
    let line = |zone: &tectum_optics::design::BlindZone| {
        let (yaw, pitch) = yaw_pitch(&zone.direction);
        format!(
            "\nblind zone around yaw {:.1}, pitch {:.1}: {:.3} sr, {:.2} % of the sphere, up to \
             {:.1} degrees from there",
            yaw.to_degrees(),
            pitch.to_degrees(),
            zone.solid_angle_sr,
            100.0 * zone.solid_angle_sr / SPHERE_SR,
            zone.reach_rad.to_degrees()
        )
    };
    forward.blind_zones.iter().map(line).collect()
}
