//! The distance at which the pictures are joined: as it is given, and what is said of it.

use serde_json::{Value, json};
use tectum_stitch::distance::{Toward, named};
use tectum_stitch::session::{Distance, WantedDistance};

/// Reads `auto`, `boards`, `inf` or metres.
pub fn parse(text: &str) -> Result<WantedDistance, String> {
    if text == "auto" {
        return Ok(WantedDistance::OfPictures);
    }
    if text == "boards" {
        return Ok(WantedDistance::OfBoards);
    }
    let metres: f64 = text
        .parse()
        .map_err(|_| "give auto, boards, inf, or metres such as 1.5".to_owned())?;
    match metres > 0.0 {
        true => Ok(WantedDistance::Metres(metres)),
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

/// A sentence.
pub fn text(distance: &Distance) -> String {
    use WantedDistance as Wanted;
    let [taken, before] = [distance.metres(), distance.before_m].map(named);
    match (distance.wanted, distance.clear()) {
        (Wanted::Metres(_), _) => format!("{taken}, as asked"),
        (Wanted::OfBoards, _) => format!("{taken}, where the boards stand"),
        (Wanted::OfPictures, Some(found)) => format!(
            "{taken}, where the eyes' pictures are most alike: SSIM {:.2}, {:.2} at {before}",
            found.ssim, found.ssim_of_rig
        ),
        (Wanted::OfRig, Some(found)) => format!(
            "{taken}, the rig's; the eyes' pictures are more alike at {}: SSIM {:.2}, {:.2} here; \
             --distance auto takes it",
            named(found.distance_m),
            found.ssim,
            found.ssim_of_rig
        ),
        (Wanted::OfPictures, None) => {
            format!("{taken}, the rig's: the pictures do not clearly ask for another")
        }
        (Wanted::OfRig, None) => format!("{taken}, the rig's"),
    }
}

/// Where boards stand, if the pictures are joined elsewhere.
pub fn boards(distance: &Distance) -> Option<String> {
    let boards_m = distance
        .boards_m
        .filter(|_| distance.wanted != WantedDistance::OfBoards)?;
    Some(format!(
        "the boards stand at {}: --distance boards joins the pictures there",
        named(boards_m)
    ))
}

/// The same for a script.
pub fn json(distance: &Distance) -> Value {
    json!({
        "metres": distance.metres(),
        "of_rig_m": distance.before_m,
        "pictures": distance.found,
        "boards_m": distance.boards_m,
    })
}
