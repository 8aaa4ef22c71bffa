//! Page sizes.

use std::fmt;
use std::str::FromStr;

use super::{TargetError, short};

/// A page; either side may be the upper one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PageSize {
    /// Shorter and longer side, mm.
    sides_mm: [f64; 2],
}

/// ISO 216 and ANSI names.
const NAMED: [(&str, [f64; 2]); 7] = [
    ("a4", [210.0, 297.0]),
    ("a3", [297.0, 420.0]),
    ("a2", [420.0, 594.0]),
    ("a1", [594.0, 841.0]),
    ("a0", [841.0, 1189.0]),
    ("letter", [215.9, 279.4]),
    ("tabloid", [279.4, 431.8]),
];

impl PageSize {
    /// Sides that a page can have, mm.
    pub const SIDE_MM: std::ops::RangeInclusive<f64> = 100.0..=5000.0;

    /// Width and height upright, mm.
    pub fn portrait_mm(self) -> [f64; 2] {
        self.sides_mm
    }

    /// Width and height lying, mm.
    pub fn landscape_mm(self) -> [f64; 2] {
        [self.sides_mm[1], self.sides_mm[0]]
    }
}

impl FromStr for PageSize {
    type Err = TargetError;

    fn from_str(text: &str) -> Result<Self, TargetError> {
        let lower = text.to_ascii_lowercase();
        if let Some((_, sides_mm)) = NAMED.iter().find(|(name, _)| *name == lower) {
            return Ok(Self {
                sides_mm: *sides_mm,
            });
        }
        let side = |text: &str| {
            let mm: f64 = text.parse().ok()?;
            Self::SIDE_MM.contains(&mm).then_some(mm)
        };
        lower
            .split_once('x')
            .and_then(|(a, b)| Some((side(a)?, side(b)?)))
            .map(|(a, b)| Self {
                sides_mm: [a.min(b), a.max(b)],
            })
            .ok_or_else(|| TargetError::NoPage { text: text.into() })
    }
}

impl fmt::Display for PageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.sides_mm.map(short);
        write!(f, "{a} x {b} mm")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers() {
        let page = |text: &str| text.parse::<PageSize>().unwrap().portrait_mm();
        assert_eq!(page("A3"), [297.0, 420.0]);
        assert_eq!(page("letter"), [215.9, 279.4]);
        assert_eq!(page("450x300.5"), [300.5, 450.0]);
        for bad in [
            "", "a9", "x", "99x200", "200x", "nanx200", "infx200", "1e9x200", "-210x297",
        ] {
            let error = bad.parse::<PageSize>().unwrap_err().to_string();
            assert!(error.contains("100 to 5000"), "{error}");
        }
    }
}
