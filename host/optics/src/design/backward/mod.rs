//! From what the fish should see to mounts that see it.

mod figures;
mod rank;
mod solve;
#[cfg(test)]
mod tests;

use super::{DesignError, Mount, Port};

pub use figures::{Figures, Goal, Objective};

/// A range that an angle may lie in, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Least.
    pub low_rad: f64,
    /// Greatest.
    pub high_rad: f64,
}

impl Span {
    /// An angle that is given.
    pub fn fixed(rad: f64) -> Self {
        Self {
            low_rad: rad,
            high_rad: rad,
        }
    }
}

/// What mount and lens may be: the angles of the hull's tangent plane where the eyes can sit, and
/// the lenses that can be had.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// psi.
    pub psi: Span,
    /// tau.
    pub tau: Span,
    /// Whole field of the lens in air.
    pub theta: Span,
}

/// How a figure must lie to its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// At it.
    Equal,
    /// At it or above.
    AtLeast,
    /// At it or below.
    AtMost,
}

/// One figure that is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Want {
    /// Which.
    pub goal: Goal,
    /// How.
    pub relation: Relation,
    /// Value, rad; a share of the sphere is 0 to 1.
    pub value: f64,
}

/// All that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// What may be chosen.
    pub bounds: Bounds,
    /// Through what the eyes look into water; `None` is air.
    pub port: Option<Port>,
    /// What is held back of each half-angle, rad: the wish holds even if a lens sees so much less.
    pub margin_rad: f64,
    /// Figures wanted.
    pub wants: Vec<Want>,
    /// What is to be as great as can be.
    pub objective: Objective,
}

/// A mount and lens that fulfil a wish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Mount.
    pub mount: Mount,
    /// Whole field of the lens in air, rad.
    pub theta_rad: f64,
    /// Whole field in the medium, less the margin, rad: what the figures are for.
    pub theta_used_rad: f64,
    /// What it sees, by the forward form.
    pub figures: Figures,
}

/// Mounts that fulfil a wish.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// The best first; each differs from those before it by two degrees or more in some angle.
    pub best: Vec<Candidate>,
    /// The best by each other objective.
    pub trade_offs: Vec<(Objective, Candidate)>,
}

/// Why no mount fulfils a wish.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WishError {
    /// A range that holds nothing, or more than there is.
    #[error("{name}: {low_deg} to {high_deg} degrees is not allowed ({allowed})")]
    Span {
        /// Of which angle.
        name: &'static str,
        /// Least, degrees.
        low_deg: f64,
        /// Greatest, degrees.
        high_deg: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A margin out of range.
    #[error("a margin of {0} degrees is not allowed: 0 to 60")]
    Margin(f64),
    /// A figure that nothing can have.
    #[error("{name} of {value} is not allowed ({allowed})")]
    Value {
        /// Which figure.
        name: &'static str,
        /// Its value, degrees or a share.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Nothing in the bounds sees that.
    #[error(
        "no mount within the bounds sees that: the nearest, psi {psi_deg:.2} tau {tau_deg:.2} \
         theta {theta_deg:.2}, has {name} {has:.3} where {wanted:.3} is wanted. Loosen a bound or a \
         wish"
    )]
    Contradiction {
        /// The nearest mount, degrees.
        psi_deg: f64,
        /// The nearest mount, degrees.
        tau_deg: f64,
        /// The nearest lens, degrees.
        theta_deg: f64,
        /// The figure that is off most.
        name: &'static str,
        /// Its value, degrees or a share.
        has: f64,
        /// What it should be, degrees or a share.
        wanted: f64,
    },
    /// No lens and mount in the bounds see anything.
    #[error("no lens within the bounds sees anything in this medium and with this margin")]
    Blind,
    /// A mount that is none.
    #[error(transparent)]
    Design(#[from] DesignError),
}

impl Wish {
    /// Up to `count` mounts that fulfil the wish.
    ///
    /// # Errors
    /// [`WishError`] if a bound or a figure is impossible, or no mount fulfils all of it; then the
    /// nearest is named.
    pub fn solve(&self, count: usize) -> Result<Solved, WishError> {
        self.check()?;
        rank::rank(self, count)
    }

    fn check(&self) -> Result<(), WishError> {
        let spans = [
            (
                "psi",
                self.bounds.psi,
                -179.0,
                179.0,
                "within -179 to 179, low before high",
            ),
            (
                "tau",
                self.bounds.tau,
                -89.0,
                89.0,
                "within -89 to 89, low before high",
            ),
            (
                "theta",
                self.bounds.theta,
                1.0,
                358.0,
                "within 1 to 358, low before high",
            ),
        ];
        for (name, span, least_deg, greatest_deg, allowed) in spans {
            let [low_deg, high_deg] = [span.low_rad, span.high_rad].map(f64::to_degrees);
            // Degrees to radians and back: a unit in the last place.
            let inside = low_deg >= least_deg - 1e-9 && high_deg <= greatest_deg + 1e-9;
            if !(inside && low_deg <= high_deg) {
                return Err(WishError::Span {
                    name,
                    low_deg,
                    high_deg,
                    allowed,
                });
            }
        }
        if !(0.0..=60.0).contains(&self.margin_rad.to_degrees()) {
            return Err(WishError::Margin(self.margin_rad.to_degrees()));
        }
        self.wants.iter().try_for_each(Want::check)
    }
}

impl Want {
    fn check(&self) -> Result<(), WishError> {
        let (range, allowed) = self.goal.range();
        let value = self.goal.shown(self.value);
        if range.contains(&value) {
            return Ok(());
        }
        Err(WishError::Value {
            name: self.goal.name(),
            value,
            allowed,
        })
    }

    /// How far a figure is from what is wanted: 0 if it is fulfilled, positive if it is too great.
    fn excess(&self, value: f64) -> f64 {
        let excess = value - self.value;
        match self.relation {
            Relation::Equal => excess,
            Relation::AtLeast => excess.min(0.0),
            Relation::AtMost => excess.max(0.0),
        }
    }
}
