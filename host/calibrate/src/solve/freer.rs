//! A lens of more freedom through the same corners: what the chosen one leaves out, and what one view
//! more or less does to it.

use nalgebra::DMatrix;

use super::bundle::{self, Bundle, State};
use super::choice::profile;
use super::fit::{Fit, square_sum};
use super::lens::{Lens, OcamLens, TiltedLens};

/// Degrees above that of the lens chosen: the next even power and the next odd one.
const MORE_DEGREES: usize = 2;

/// Share of the cost that a step must gain for another to follow. The cost of a thousand corners is about 2000
/// times a coordinate's variance: a step that gains less moves the lens by less than a twentieth of its
/// standard error.
const CLOSE: f64 = 1e-6;

/// A polynomial of a higher degree than the chosen lens needs, with skew, decentring and a tilted sensor
/// free, fitted to the same corners.
///
/// Where the chosen lens is too stiff for the true one, its corners' residuals hardly tell: the boards'
/// poses take up most of what it gets wrong. The freer lens takes it up itself, so that the difference
/// between both is the model's error. This is how mrcal (Kogan 2021) compares a lean and a rich model.
#[derive(Debug, Clone, PartialEq)]
pub struct FreerLens {
    degree: usize,
    scale_px: f64,
    p: Vec<f64>,
    /// Of `p`, from the corners' noise.
    by_noise: DMatrix<f64>,
    /// Of `p`, from what leaving out one view does; `None` where a view cannot be spared.
    by_views: Option<DMatrix<f64>>,
}

impl FreerLens {
    /// Fits it to the views of a fit of the lens `base_lens`; `degree` is that of the polynomial chosen.
    /// `None` if the corners do not fix it.
    pub(super) fn new(base_lens: &OcamLens, base: &Fit, degree: usize) -> Option<Self> {
        let degree = (degree + MORE_DEGREES).min(*OcamLens::DEGREES.end());
        let scale_px = base_lens.scale_px();
        let lens = lens(degree, scale_px);
        let start = lens.meet_profile([base.p[0], base.p[1]], &profile(base_lens, base))?;
        let fit = base.refined(&lens, start, 100, CLOSE)?;
        let (sights, poses) = fit.active();
        let (sum, count) = square_sum(&lens, &fit.p, &sights, &poses);
        let unknowns = lens.count() + 6 * poses.len();
        let freedom = (2 * count).checked_sub(unknowns).filter(|n| *n > 0)?;
        let bundle = Bundle {
            lens: &lens,
            sights: &sights,
            loss: fit.loss(),
            free_shape: false,
            end: bundle::EXACT,
        };
        let state = State {
            lens: fit.p.clone(),
            poses,
            shape: crate::board_shape::Terms::zeros(),
            cost: 0.0,
        };
        Some(Self {
            degree,
            scale_px,
            by_noise: bundle.cofactors(&state)? * (sum / freedom as f64),
            by_views: bundle.jackknife(&state),
            p: fit.p,
        })
    }

    /// The family.
    pub(super) fn lens(&self) -> TiltedLens {
        lens(self.degree, self.scale_px)
    }

    /// Its parameters.
    pub(super) fn parameters(&self) -> &[f64] {
        &self.p
    }

    /// Covariances of its parameters, of which the greater holds.
    pub(super) fn covariances(&self) -> impl Iterator<Item = &DMatrix<f64>> {
        std::iter::once(&self.by_noise).chain(&self.by_views)
    }
}

fn lens(degree: usize, scale_px: f64) -> TiltedLens {
    let lens = OcamLens::new(degree, scale_px);
    TiltedLens::new(lens.with_skew(true).with_decentring(true))
}
