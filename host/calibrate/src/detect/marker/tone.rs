//! Grey levels of a mixture of black and white.

/// How a picture codes light: light is a power of the grey level, 1 for light as it is, some 2.2
/// for pictures made to be looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tone {
    pub gamma: f64,
}

/// A grey level, 0 to 255, and its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    pub level: f64,
    /// By the share of white.
    pub by_share: f64,
    pub by_dark: f64,
    pub by_bright: f64,
    pub by_log_gamma: f64,
}

impl Tone {
    /// Light of a grey level, both 0 to 1.
    pub fn light(&self, level: f64) -> f64 {
        libm::pow(level, self.gamma)
    }

    /// Grey level of a share of light `bright` (grey levels) and the rest `dark`.
    pub fn mix(&self, share: f64, dark: f64, bright: f64) -> Level {
        // Black that a picture cuts off has no logarithm.
        let [dark, bright] = [dark, bright].map(|level| level.max(1.0) / 255.0);
        let (black, white) = (self.light(dark), self.light(bright));
        let mixed = ((1.0 - share) * black + share * white).max(1e-9);
        let level = 255.0 * libm::pow(mixed, 1.0 / self.gamma);
        // Derivative by light.
        let rise = level / (self.gamma * mixed);
        let ends = (1.0 - share) * black * libm::log(dark) + share * white * libm::log(bright);
        Level {
            level,
            by_share: rise * (white - black),
            by_dark: level / mixed * (1.0 - share) * black / (dark * 255.0),
            by_bright: level / mixed * share * white / (bright * 255.0),
            by_log_gamma: level * (ends / mixed - libm::log(mixed) / self.gamma),
        }
    }
}
