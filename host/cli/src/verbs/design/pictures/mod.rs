//! Pictures of a mount and what it sees, each as SVG and PNG.

mod map;
mod mount;
mod raster;
mod section;
mod sheet;
mod sphere;

use std::path::Path;

use tectum_optics::design::{BothEyes, Circle, Forward, Section, Shares};

use self::sheet::{Anchor, Sheet};
use super::forward::Plane;
use crate::areas::colour;
use crate::draw::WHITE;
use crate::{files, pictures};

/// Writes all into a folder; the names of the files.
pub fn write(
    folder: &Path,
    eyes: &BothEyes,
    forward: &Forward,
    planes: &[Plane],
) -> anyhow::Result<Vec<String>> {
    let axes = [eyes.left.axis(), eyes.right.axis()];
    let design = Circle::through(&axes[0], &axes[1])?;
    let mut sheets = vec![
        ("map".to_owned(), map::draw(eyes, forward)?),
        ("sphere".to_owned(), sphere::draw(eyes, forward)),
        ("mount".to_owned(), mount::draw(eyes, forward)),
        (
            "horizontal".to_owned(),
            section::draw(
                "horizontal plane",
                &Circle::horizontal(),
                &forward.horizontal,
            ),
        ),
        (
            "design-plane".to_owned(),
            section::draw("design plane", &design, &forward.design),
        ),
    ];
    for plane in planes {
        let section = Section::of(eyes, &plane.circle);
        let sheet = section::draw(&plane.name, &plane.circle, &section);
        sheets.push((plane.file.clone(), sheet));
    }
    let mut names = Vec::new();
    for (name, sheet) in sheets {
        let [svg, png] = ["svg", "png"].map(|end| format!("{name}.{end}"));
        files::write(&folder.join(&svg), sheet.svg(&name).as_bytes())?;
        pictures::save(&folder.join(&png), sheet.png())?;
        names.extend([svg, png]);
    }
    Ok(names)
}

/// Who sees how much, in one line of swatches.
fn legend(sheet: &mut Sheet, y: f64, shares: &Shares) {
    use tectum_optics::design::Area;
    let entries = [
        (Area::Left, "left only", shares.left_only),
        (Area::Right, "right only", shares.right_only),
        (Area::Both, "both", shares.both),
        (Area::None, "blind", shares.blind()),
    ];
    let slot = sheet.width() / entries.len() as f64;
    for (i, (area, name, share)) in entries.into_iter().enumerate() {
        let x = slot * i as f64 + 40.0;
        let square = [[0.0, 0.0], [16.0, 0.0], [16.0, 16.0], [0.0, 16.0]];
        let corners = square.map(|[dx, dy]| [x + dx, y - 8.0 + dy]);
        sheet.fill(corners, colour(area), 1.0);
        sheet.line(corners.into_iter().chain([corners[0]]), WHITE, 1.0);
        let words = format!("{name} {:.1} %", 100.0 * share);
        sheet.text([x + 24.0, y], Anchor::Start, WHITE, &words);
    }
}
