//! What water takes from a lens.

use super::DesignError;
use crate::front_element::FrontElementError;
use crate::{Field, FrontElement};

/// What lies between the lens and the water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Port {
    /// A plane window: sin(water) = sin(air) / n.
    Flat,
    /// A dome about the entrance pupil: no change.
    Dome,
    /// The lens itself is wet.
    Bare(FrontElement),
}

impl Port {
    /// Angle off the axis in water of the ray that in air is at `air_rad`; a flat window shows no
    /// ray beyond grazing, so wider ones end there.
    ///
    /// # Errors
    /// [`FrontElementError::Grazing`] if a wet lens has no such ray: its kappa is wrong.
    pub fn water_rad(self, air_rad: f64) -> Result<f64, FrontElementError> {
        match self {
            Self::Dome => Ok(air_rad),
            Self::Flat => {
                let front = FrontElement::new(1.0)?;
                Ok(front.water_rad(air_rad.min(front.limit_air_rad())))
            }
            Self::Bare(front) if air_rad > front.limit_air_rad() => {
                Err(FrontElementError::Grazing {
                    kappa: front.kappa(),
                    limit_deg: front.limit_air_rad().to_degrees(),
                    claimed_deg: air_rad.to_degrees(),
                })
            }
            Self::Bare(front) => Ok(front.water_rad(air_rad)),
        }
    }

    /// A field in water.
    ///
    /// # Errors
    /// As [`Port::water_rad`].
    pub fn field(self, air: &Field) -> Result<Field, DesignError> {
        let halves = air.half_angles_rad().iter();
        let water = halves
            .map(|half| self.water_rad(*half))
            .collect::<Result<_, _>>()?;
        let claimed_deg = air.widest_rad().to_degrees();
        // Water only narrows: angles stay in range unless one is too small for a number.
        Field::new(water).map_err(|_| FrontElementError::Model { claimed_deg }.into())
    }
}
