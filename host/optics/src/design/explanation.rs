//! Can one front of a lens, and the sensor behind it, explain fields measured in water?

use super::{BothEyes, Circle, DesignError, Mount, Port, Section};
use crate::{Field, FrontElement};

/// A field measured on a plane through the left-right axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Elevation of the plane's front half, rad: 0 or zeta.
    pub elevation_rad: f64,
    /// How far the field reaches around, rad.
    pub outer_rad: f64,
}

/// kappa fitted on one measured field, and what it says about another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explanation {
    /// The front that gives the field that was fitted.
    pub front: FrontElement,
    /// What it predicts on the other plane, rad.
    pub predicted_rad: f64,
    /// Predicted less measured, rad.
    pub error_rad: f64,
}

impl Explanation {
    /// Fits the front of lenses with field `air` on `fitted`, predicts `other`.
    ///
    /// # Errors
    /// [`DesignError::Unreachable`] if no front gives the field measured.
    pub fn of(
        mount: &Mount,
        air: &Field,
        fitted: Reading,
        other: Reading,
    ) -> Result<Self, DesignError> {
        let outer = |kappa: f64, elevation_rad: f64| {
            let wet = Port::Bare(FrontElement::new(kappa)?).field(air)?;
            let eyes = BothEyes::of_mount(mount, &wet);
            Ok::<_, DesignError>(Section::of(&eyes, &Circle::pencil(elevation_rad)).outer_rad())
        };
        // A hair below grazing at the rim.
        let limit = (0.999_999 * std::f64::consts::FRAC_PI_2 / air.widest_rad()).min(1.0);
        let (mut low, mut high) = (0.0, limit);
        let reached = outer(high, fitted.elevation_rad)?..=outer(low, fitted.elevation_rad)?;
        if !reached.contains(&fitted.outer_rad) {
            return Err(DesignError::Unreachable {
                measured_deg: fitted.outer_rad.to_degrees(),
            });
        }
        // A flatter front sees less. Thirty halvings: kappa to 1e-9.
        for _ in 0..30 {
            let middle = (low + high) / 2.0;
            match outer(middle, fitted.elevation_rad)? > fitted.outer_rad {
                true => low = middle,
                false => high = middle,
            }
        }
        let kappa = (low + high) / 2.0;
        let predicted_rad = outer(kappa, other.elevation_rad)?;
        Ok(Self {
            front: FrontElement::new(kappa)?,
            predicted_rad,
            error_rad: predicted_rad - other.outer_rad,
        })
    }
}
