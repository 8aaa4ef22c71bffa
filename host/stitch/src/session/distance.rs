//! The distance at which the pictures are joined.

use image::RgbImage;
use tectum_optics::Rig;

use super::SessionError;
use crate::Eyes;
use crate::distance::{SceneDistance, Toward, known_distance, scene_distance};
use crate::registration::Tie;

/// Pairs that are looked at: each takes a second.
const LOOKED_AT: usize = 3;

/// Where the pictures are to be joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WantedDistance {
    /// Where the rig has it.
    OfRig,
    /// Where the pictures say, if they say it clearly.
    OfPictures,
    /// Where the boards stand.
    OfBoards,
    /// Here, m; may be infinite.
    Metres(f64),
}

/// The distance taken, and why.
#[derive(Debug, Clone)]
pub struct Distance {
    /// The rig with it.
    pub rig: Rig,
    /// What was asked for.
    pub wanted: WantedDistance,
    /// The rig's before, m.
    pub before_m: f64,
    /// What the pictures say, if they were asked.
    pub found: Option<SceneDistance>,
    /// Where boards stand, m.
    pub boards_m: Option<f64>,
}

impl Distance {
    /// Looks at some of the pictures, and takes what was asked for.
    pub(super) fn choose(
        wanted: WantedDistance,
        rig: &Rig,
        pictures: &[Eyes<RgbImage>],
        toward: Toward,
        ties: &[Tie],
    ) -> Result<Self, SessionError> {
        let mut chosen = Self {
            rig: rig.clone(),
            wanted,
            before_m: rig.stitch_distance_m,
            found: None,
            boards_m: known_distance(rig, ties),
        };
        if wanted == WantedDistance::OfBoards {
            let metres = chosen.boards_m.ok_or(SessionError::NoBoardDistance)?;
            chosen.rig = rig.with_stitch_distance(metres)?;
            return Ok(chosen);
        }
        if let WantedDistance::Metres(metres) = wanted {
            chosen.rig = rig.with_stitch_distance(metres)?;
            return Ok(chosen);
        }
        let every = pictures.len().div_ceil(LOOKED_AT).max(1);
        let shots: Vec<Eyes<&RgbImage>> = pictures
            .iter()
            .step_by(every)
            .map(|pair| pair.each_ref())
            .collect();
        chosen.found = scene_distance(rig, &shots, toward)?;
        if let (WantedDistance::OfPictures, Some(found)) = (wanted, &chosen.found)
            && found.is_clear
        {
            chosen.rig = rig.with_stitch_distance(found.distance_m)?;
        }
        Ok(chosen)
    }

    /// The distance taken, m.
    pub fn metres(&self) -> f64 {
        self.rig.stitch_distance_m
    }

    /// What the pictures say, if they say it clearly.
    pub fn clear(&self) -> Option<&SceneDistance> {
        self.found.as_ref().filter(|found| found.is_clear)
    }
}
