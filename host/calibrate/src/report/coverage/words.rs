//! Gaps in plain words.

use std::fmt;

use super::gap::LEAST_ALTOGETHER;
use super::{Direction, Gap};

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewPictures { pictures } => {
                match pictures {
                    0 => f.write_str("no picture with a board"),
                    1 => f.write_str("only 1 picture with a board"),
                    n => write!(f, "only {n} pictures with a board"),
                }?;
                let more = 2 * LEAST_ALTOGETHER - (*pictures).min(LEAST_ALTOGETHER);
                write!(f, ": take {more} more")
            }
            Self::Beyond {
                angle_rad,
                directions,
                take,
            } => write!(
                f,
                "no board beyond {:.0} degrees {}: take {take} more pictures there",
                angle_rad.to_degrees(),
                At(directions)
            ),
            Self::Between {
                from_rad,
                to_rad,
                directions,
                pictures,
                take,
            } => {
                let one = ["no board", "only one picture of a board"];
                write!(f, "{} ", one[(*pictures).min(1)])?;
                let to = to_rad.to_degrees();
                if directions.is_empty() {
                    write!(f, "within {to:.0} degrees of the axis")?;
                } else {
                    let from = from_rad.to_degrees();
                    write!(f, "at {from:.0} to {to:.0} degrees {}", At(directions))?;
                }
                write!(f, ": take {take} more pictures there")
            }
            Self::Parallel { spread_rad } => write!(
                f,
                "all boards are parallel to within {:.0} degrees: tilt the board by 20 to 50 \
                 degrees in 6 more pictures, each time about another side",
                spread_rad.to_degrees().max(1.0)
            ),
            Self::OneDistance {
                nearest_mm,
                farthest_mm,
            } => write!(
                f,
                "all boards are {nearest_mm:.0} to {farthest_mm:.0} mm away: take 4 more pictures \
                 at half or twice that"
            ),
        }
    }
}

/// "at left and upper left".
struct At<'a>(&'a [Direction]);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.len() == Direction::ALL.len() {
            return f.write_str("all round");
        }
        f.write_str("at ")?;
        for (k, direction) in self.0.iter().enumerate() {
            let before = match self.0.len() - k {
                _ if k == 0 => "",
                1 => " and ",
                _ => ", ",
            };
            write!(f, "{before}{direction}")?;
        }
        Ok(())
    }
}
