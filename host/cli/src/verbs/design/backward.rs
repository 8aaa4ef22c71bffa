//! Mounts for a wish.

use serde_json::{Value, json};
use tectum_optics::design::{Bounds, Candidate, Objective, Span, Wish};

use super::args::{Args, Range};
use super::given;
use crate::report::{Report, Usage};

/// Solves and reports.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    if args.pictures.is_some() || !args.plane.is_empty() || !args.plane_normal.is_empty() {
        let message = "--pictures and planes are for one mount: give --psi, --tau and --theta";
        return Err(Usage(message.into()).into());
    }
    let theta = args
        .theta
        .ok_or_else(|| Usage("a wish needs --theta, a lens or a range of lenses".into()))?;
    let spans = match &args.normal {
        Some(_) => given::mount(args)?
            .map(|mount| [mount.psi_rad(), mount.tau_rad()].map(Span::fixed))
            .unwrap_or([Span::fixed(0.0); 2]),
        None => {
            let or = |range: Option<Range>, low, high| range.unwrap_or(Range { low, high }).into();
            [or(args.psi, 0.0, 90.0), or(args.tau, 0.0, 60.0)]
        }
    };
    let objective = args
        .wish
        .best
        .map_or(Objective::TotalField, Objective::from);
    let wish = Wish {
        bounds: Bounds {
            psi: spans[0],
            tau: spans[1],
            theta: theta.into(),
        },
        port: args.medium.port(args.kappa)?,
        margin_rad: args.wish.margin.unwrap_or(0.0).to_radians(),
        wants: args
            .wish
            .want
            .iter()
            .flat_map(|want| want.0.clone())
            .collect(),
        objective,
    };
    let solved = wish.solve(usize::from(args.wish.count))?;
    let best = &solved.best[0];
    let mut text = format!(
        "mounts by {}, in {}{}\n{}",
        objective.name(),
        args.medium.words(),
        match args.wish.margin {
            Some(margin) => format!(", {margin} degrees of each half-angle held back"),
            None => String::new(),
        },
        HEAD,
    );
    for (i, candidate) in solved.best.iter().enumerate() {
        text += &row(&format!("{}", i + 1), candidate);
    }
    text += "\n\ntrade-offs: the best by something else";
    text += HEAD;
    for (other, candidate) in &solved.trade_offs {
        text += &row(other.name(), candidate);
    }
    text += "\n\nlens is in air, used what counts of it here; all in degrees, seen and both in % of \
             the sphere.\nmargin: what the used field may lose before the horizontal view ahead has a \
             gap.";
    let trade_offs = solved.trade_offs.iter().map(|(other, candidate)| {
        let [now, then] = [best, candidate].map(|c| objective.value(&c.figures));
        let mut value = candidate_json(candidate);
        value["best_by"] = json!(other.name());
        // An angle but for shares.
        value["costs"] = json!(match objective {
            Objective::TotalField | Objective::Margin => (now - then).to_degrees(),
            Objective::SphereSeen | Objective::SphereBoth => now - then,
        });
        value
    });
    let json = json!({
        "objective": objective.name(),
        "medium": args.medium.words(),
        "margin_deg": args.wish.margin.unwrap_or(0.0),
        "mounts": solved.best.iter().map(candidate_json).collect::<Vec<_>>(),
        "trade_offs": trade_offs.collect::<Vec<_>>(),
    });
    Ok(Report::new(text, json))
}

const HEAD: &str = "\n               psi     tau    lens    used    zeta      xi     phi   total   front   \
                    outer   seen   both  margin";

fn row(name: &str, candidate: &Candidate) -> String {
    let deg = f64::to_degrees;
    let figures = &candidate.figures;
    let angles = [
        candidate.mount.psi_rad(),
        candidate.mount.tau_rad(),
        candidate.theta_rad,
        candidate.theta_used_rad,
        figures.zeta_rad,
        figures.xi_rad,
        figures.phi_rad,
        figures.total_rad,
        figures.front_rad,
        figures.outer_rad,
    ];
    let angles: String = angles.map(|rad| format!("{:>8.2}", deg(rad))).concat();
    format!(
        "\n{name:<11}{angles}{:>7.2}{:>7.2}{:>8.2}",
        100.0 * figures.seen,
        100.0 * figures.both,
        deg(figures.margin_rad)
    )
}

fn candidate_json(candidate: &Candidate) -> Value {
    let deg = f64::to_degrees;
    let figures = &candidate.figures;
    json!({
        "psi_deg": deg(candidate.mount.psi_rad()),
        "tau_deg": deg(candidate.mount.tau_rad()),
        "theta_deg": deg(candidate.theta_rad),
        "theta_used_deg": deg(candidate.theta_used_rad),
        "zeta_deg": deg(figures.zeta_rad),
        "xi_deg": deg(figures.xi_rad),
        "phi_deg": deg(figures.phi_rad),
        "theta_total_deg": deg(figures.total_rad),
        "horizontal": {
            "outer_deg": deg(figures.outer_rad),
            "front_overlap_deg": deg(figures.front_rad),
        },
        "sphere": { "seen": figures.seen, "both": figures.both },
        "margin_deg": deg(figures.margin_rad),
    })
}
