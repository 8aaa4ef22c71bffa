//! The distance at which the pictures are joined.

use anyhow::Context;
use image::RgbImage;
use serde_json::{Value, json};
use tectum_optics::Rig;
use tectum_stitch::Eyes;
use tectum_stitch::distance::{SceneDistance, Toward, known_distance, scene_distance};
use tectum_stitch::registration::Tie;

/// Pairs that are looked at: each takes a second.
const LOOKED_AT: usize = 3;

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// What the pictures say, if they say it clearly.
    Auto,
    /// Where the boards stand.
    Boards,
    /// This, m.
    Metres(f64),
}

/// Reads `auto`, `boards`, `inf` or metres.
pub fn parse(text: &str) -> Result<Wanted, String> {
    if text == "auto" {
        return Ok(Wanted::Auto);
    }
    if text == "boards" {
        return Ok(Wanted::Boards);
    }
    let metres: f64 = text
        .parse()
        .map_err(|_| "give auto, boards, inf, or metres such as 1.5".to_owned())?;
    match metres > 0.0 {
        true => Ok(Wanted::Metres(metres)),
        false => Err("a distance is above 0".to_owned()),
    }
}

/// Reads a range of yaws `FROM..TO`, degrees, or `all`.
pub fn parse_toward(text: &str) -> Result<Toward, String> {
    if text == "all" {
        return Ok(Toward::Everywhere);
    }
    let ends = text.split_once("..").and_then(|(from, to)| {
        let deg = |text: &str| text.parse().ok().filter(|deg: &f64| deg.abs() <= 360.0);
        Some([deg(from)?, deg(to)?])
    });
    match ends {
        Some([from, to]) if from < to && to - from <= 360.0 => {
            Ok(Toward::Yaws(from.to_radians(), to.to_radians()))
        }
        _ => Err("give all, or yaws in degrees from right to left such as -30..30".to_owned()),
    }
}

/// The distance taken, and why.
pub struct Distance {
    /// The rig with it.
    pub rig: Rig,
    wanted: Option<Wanted>,
    /// The rig's before.
    before_m: f64,
    /// What the pictures say.
    found: Option<SceneDistance>,
    /// Where boards stand, m.
    boards_m: Option<f64>,
}

impl Distance {
    /// Looks at some of the pictures, and takes what was asked for.
    pub fn choose(
        wanted: Option<Wanted>,
        rig: &Rig,
        pictures: &[Eyes<RgbImage>],
        toward: Toward,
        ties: &[Tie],
    ) -> anyhow::Result<Self> {
        let mut chosen = Self {
            rig: rig.clone(),
            wanted,
            before_m: rig.stitch_distance_m,
            found: None,
            boards_m: known_distance(rig, ties),
        };
        if wanted == Some(Wanted::Boards) {
            let metres = chosen.boards_m.context(
                "--distance boards needs boards whose corners are matched: give --target or --board",
            )?;
            chosen.rig = rig.with_stitch_distance(metres)?;
            return Ok(chosen);
        }
        if let Some(Wanted::Metres(metres)) = wanted {
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
        if let (Some(Wanted::Auto), Some(found)) = (wanted, &chosen.found)
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

    /// A sentence.
    pub fn text(&self) -> String {
        let [taken, before] = [self.metres(), self.before_m].map(named);
        let clear = self.found.as_ref().filter(|found| found.is_clear);
        match (self.wanted, clear) {
            (Some(Wanted::Metres(_)), _) => format!("{taken}, as asked"),
            (Some(Wanted::Boards), _) => format!("{taken}, where the boards stand"),
            (Some(Wanted::Auto), Some(found)) => format!(
                "{taken}, where the eyes' pictures are most alike: SSIM {:.2}, {:.2} at {before}",
                found.ssim, found.ssim_of_rig
            ),
            (None, Some(found)) => format!(
                "{taken}, the rig's; the eyes' pictures are more alike at {}: SSIM {:.2}, {:.2} here; \
                 --distance auto takes it",
                named(found.distance_m),
                found.ssim,
                found.ssim_of_rig
            ),
            (Some(Wanted::Auto), None) => {
                format!("{taken}, the rig's: the pictures do not clearly ask for another")
            }
            (None, None) => format!("{taken}, the rig's"),
        }
    }

    /// Where boards stand, if the pictures are joined elsewhere.
    pub fn boards(&self) -> Option<String> {
        let boards_m = self
            .boards_m
            .filter(|_| self.wanted != Some(Wanted::Boards))?;
        Some(format!(
            "the boards stand at {}: --distance boards joins the pictures there",
            named(boards_m)
        ))
    }

    /// A better one that was not taken, in a few words.
    pub fn hint(&self) -> Option<String> {
        let found = self.found.as_ref().filter(|found| found.is_clear)?;
        self.wanted
            .is_none()
            .then(|| format!("the pictures ask for {}", named(found.distance_m)))
    }

    /// The same for a script.
    pub fn json(&self) -> Value {
        json!({
            "metres": self.metres(),
            "of_rig_m": self.before_m,
            "pictures": self.found,
            "boards_m": self.boards_m,
        })
    }
}

/// Metres, or infinity.
pub fn named(metres: f64) -> String {
    match metres.is_finite() {
        true => format!("{metres} m"),
        false => "infinity".to_owned(),
    }
}
