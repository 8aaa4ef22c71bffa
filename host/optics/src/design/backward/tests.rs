use super::*;
use crate::Field;
use crate::FrontElement;
use crate::design::{BothEyes, Forward};

fn span(low_deg: f64, high_deg: f64) -> Span {
    Span {
        low_rad: low_deg.to_radians(),
        high_rad: high_deg.to_radians(),
    }
}

fn wish(wants: &[(Goal, Relation, f64)]) -> Wish {
    let wants = wants.iter().map(|(goal, relation, shown)| Want {
        goal: *goal,
        relation: *relation,
        value: if goal.is_share() {
            *shown
        } else {
            shown.to_radians()
        },
    });
    Wish {
        bounds: Bounds {
            psi: span(0.0, 90.0),
            tau: span(0.0, 60.0),
            theta: Span::fixed(210f64.to_radians()),
        },
        port: None,
        margin_rad: 0.0,
        wants: wants.collect(),
        objective: Objective::TotalField,
    }
}

/// What is promised: a hundredth of a degree, through the forward form with nothing shared but the
/// mount and the field.
#[track_caller]
fn gives(candidate: &Candidate, goal: Goal, shown: f64) {
    let field = Field::new(vec![candidate.theta_used_rad / 2.0]).unwrap();
    let forward = Forward::of(&BothEyes::of_mount(&candidate.mount, &field)).unwrap();
    let value = match goal {
        Goal::Zeta => forward.mount.zeta_rad(),
        Goal::Xi => forward.mount.xi_rad(),
        Goal::Phi => forward.phi_rad(),
        Goal::Total => forward.theta_total_rad(),
        Goal::Front => forward.horizontal.front_overlap_rad(),
        Goal::Outer => forward.horizontal.outer_rad(),
        Goal::Seen => forward.shares.seen(),
        Goal::Both => forward.shares.both,
    };
    let off = goal.shown(value) - shown;
    assert!(
        off.abs() < 0.01,
        "{goal:?} {} {shown} {candidate:?}",
        goal.shown(value)
    );
}

#[test]
fn two_wishes_fix_the_mount() {
    for wants in [
        [(Goal::Zeta, 68.26), (Goal::Phi, 93.26)],
        [(Goal::Xi, 64.91), (Goal::Total, 326.74)],
        [(Goal::Front, 60.2), (Goal::Zeta, 45.0)],
        [(Goal::Outer, 340.0), (Goal::Front, 10.0)],
        [(Goal::Seen, 0.95), (Goal::Front, 60.0)],
        [(Goal::Both, 0.3), (Goal::Zeta, 80.0)],
    ] {
        let mut wish = wish(&wants.map(|(goal, value)| (goal, Relation::Equal, value)));
        wish.bounds.theta = match wants[0].0 {
            // A lens of 210 degrees reaches all the way round behind.
            Goal::Outer => Span::fixed(176f64.to_radians()),
            _ => wish.bounds.theta,
        };
        let solved = wish
            .solve(3)
            .unwrap_or_else(|error| panic!("{wants:?}: {error}"));
        for candidate in &solved.best {
            wants
                .iter()
                .for_each(|(goal, value)| gives(candidate, *goal, *value));
        }
    }
}

#[test]
fn the_papers_mount_is_found_again() {
    let wish = wish(&[
        (Goal::Zeta, Relation::Equal, 68.2598),
        (Goal::Phi, Relation::Equal, 93.2553),
    ]);
    let best = wish.solve(1).unwrap().best[0];
    // The wishes have four decimals.
    assert!(
        (best.mount.psi_rad().to_degrees() - 25.7).abs() < 1e-3,
        "{best:?}"
    );
    assert!((best.mount.tau_rad().to_degrees() - 29.15).abs() < 1e-3);
}

#[test]
fn one_wish_leaves_a_choice_that_is_ranked() {
    let wish = wish(&[(Goal::Front, Relation::Equal, 40.0)]);
    let solved = wish.solve(5).unwrap();
    assert_eq!(solved.best.len(), 5);
    for pair in solved.best.windows(2) {
        let [a, b] = [0, 1].map(|i| Objective::TotalField.score(&pair[i].figures));
        assert!(a >= b, "{pair:?}");
    }
    for candidate in &solved.best {
        gives(candidate, Goal::Front, 40.0);
    }
    for (objective, candidate) in &solved.trade_offs {
        gives(candidate, Goal::Front, 40.0);
        let [other, best] = [candidate, &solved.best[0]].map(|c| objective.value(&c.figures));
        // As good as the chosen one in its own field.
        assert!(other >= best - 1e-9, "{objective:?} {candidate:?}");
    }
}

/// `max 2 theta - phi` with free angles: the axes as far apart as the bounds let them be.
#[test]
fn equation_1_alone_turns_the_eyes_apart() {
    let mut wish = wish(&[]);
    wish.bounds.psi = span(20.0, 60.0);
    wish.bounds.tau = span(15.0, 40.0);
    wish.bounds.theta = Span::fixed(150f64.to_radians());
    let best = wish.solve(1).unwrap().best[0];
    // The climb ends with steps of 1e-6 rad.
    assert!(
        (best.mount.psi_rad().to_degrees() - 20.0).abs() < 1e-3,
        "{best:?}"
    );
    assert!(
        (best.mount.tau_rad().to_degrees() - 15.0).abs() < 1e-3,
        "{best:?}"
    );
}

#[test]
fn limits_hold_and_water_and_margin_are_taken_off() {
    let mut wish = wish(&[
        (Goal::Front, Relation::AtLeast, 5.0),
        (Goal::Zeta, Relation::AtMost, 50.0),
    ]);
    wish.port = Some(Port::Bare(FrontElement::new(0.694).unwrap()));
    wish.margin_rad = 2f64.to_radians();
    let solved = wish.solve(4).unwrap();
    for candidate in &solved.best {
        assert!(
            candidate.figures.front_rad.to_degrees() > 4.99,
            "{candidate:?}"
        );
        assert!(
            candidate.figures.zeta_rad.to_degrees() < 50.01,
            "{candidate:?}"
        );
        // 155.84 degrees in water, less twice the margin.
        assert!((candidate.theta_used_rad.to_degrees() - 151.84).abs() < 0.05);
    }
    // The limit that costs field is used up.
    assert!((solved.best[0].figures.front_rad.to_degrees() - 5.0).abs() < 0.01);
}

#[test]
fn a_free_lens_is_found_for_a_given_hull() {
    let mut wish = wish(&[(Goal::Front, Relation::Equal, 20.0)]);
    wish.bounds = Bounds {
        psi: Span::fixed(25.7f64.to_radians()),
        tau: Span::fixed(29.15f64.to_radians()),
        theta: span(120.0, 220.0),
    };
    let solved = wish.solve(3).unwrap();
    assert_eq!(solved.best.len(), 1);
    gives(&solved.best[0], Goal::Front, 20.0);
}

#[test]
fn what_cannot_be_is_said() {
    let equal = Relation::Equal;
    let contradiction = wish(&[
        (Goal::Phi, equal, 90.0),
        (Goal::Total, equal, 300.0),
        (Goal::Zeta, equal, 10.0),
    ]);
    let error = contradiction.solve(1).unwrap_err();
    assert!(matches!(error, WishError::Contradiction { .. }), "{error}");
    assert!(error.to_string().contains("nearest"), "{error}");
    let mut far = wish(&[(Goal::Front, equal, 300.0)]);
    far.bounds.theta = Span::fixed(2.0);
    assert!(matches!(far.solve(1), Err(WishError::Contradiction { .. })));
    for (goal, value) in [
        (Goal::Total, 400.0),
        (Goal::Seen, 1.2),
        (Goal::Zeta, f64::NAN),
    ] {
        let error = wish(&[(goal, equal, value)]).solve(1).unwrap_err();
        assert!(matches!(error, WishError::Value { .. }), "{error}");
    }
    let mut bounds = wish(&[]);
    bounds.bounds.psi = span(30.0, 20.0);
    assert!(matches!(
        bounds.solve(1),
        Err(WishError::Span { name: "psi", .. })
    ));
    let mut margin = wish(&[]);
    margin.margin_rad = f64::NAN;
    assert!(matches!(margin.solve(1), Err(WishError::Margin(_))));
    let mut blind = wish(&[]);
    blind.bounds.theta = Span::fixed(0.5);
    blind.margin_rad = 1.0;
    assert_eq!(blind.solve(1), Err(WishError::Blind));
}
