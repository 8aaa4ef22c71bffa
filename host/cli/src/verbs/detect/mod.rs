//! `tectum detect`: corners and markers in pictures.

mod drawing;
mod tables;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::bail;
use serde_json::json;
use tectum_calibrate::session::{Detections, Targets, list, mirrored};
use tectum_calibrate::{BoardSize, Dictionary};

use crate::report::{Report, path_json};
use crate::{detecting, files, pictures};

/// Corners of chessboards and markers in pictures, drawn and as data
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum detect session/*.png --board 8x6 -o found          drawn, as JSON and as CSV\n  \
    tectum detect session --board 8x6 --json\n  \
    tectum detect overlap.jpg --markers DICT_4X4_50 --board 5x4 --csv corners.csv\n\n\
    A board is told by its inner corners, columns x rows: 9 x 7 squares are 8x6. Labels: i along\n\
    the columns, j along the rows; positions in px, x right, y down, 0-based, an integer is a\n\
    pixel's centre. A corner that is not sure is left out. With -o, detections are kept in\n\
    DIR/session: a second run does only what is new.")]
pub struct Args {
    /// Pictures or folders of pictures
    #[arg(required = true, value_name = "PICTURES")]
    pictures: Vec<PathBuf>,
    /// Inner corners of the chessboard, columns x rows
    #[arg(long, value_name = "8x6", value_parser = detecting::board, required_unless_present = "markers")]
    board: Option<BoardSize>,
    /// Dictionary of the markers, such as DICT_4X4_50
    #[arg(long, value_name = "NAME")]
    markers: Option<Dictionary>,
    /// Folder for drawn pictures, corners.json and corners.csv
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Table of all corners and markers to write
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Folder that keeps the detections (default: DIR/session with -o, else none)
    #[arg(long, value_name = "DIR")]
    session: Option<PathBuf>,
}

/// Detects.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let targets = Targets {
        board: args.board,
        markers: args.markers.clone(),
    };
    let paths = list(&args.pictures)?;
    let drawings = args
        .output
        .as_deref()
        .map(|folder| drawing_names(folder, &paths));
    let csv = [
        args.csv.clone(),
        args.output.as_ref().map(|dir| dir.join("corners.csv")),
    ];
    let csv: Vec<PathBuf> = csv.into_iter().flatten().collect();
    let corners = args.output.as_ref().map(|dir| dir.join("corners.json"));
    let drawn = drawings.iter().flatten();
    files::check_outputs(csv.iter().chain(&corners).chain(drawn), &paths)?;
    let kept = args.output.as_ref().map(|folder| folder.join("session"));
    let detections = detecting::run(&paths, &targets, args.session.clone().or(kept))?;
    let readable = detections.readable();
    if readable.is_empty() {
        bail!(
            "none of the {} pictures can be read:\n{}",
            paths.len(),
            detecting::notes(&detections)
        );
    }
    let files = readable.iter().map(|(index, _)| &*paths[*index]);
    let mirrored = mirrored(&detections, args.markers.as_ref(), files, &detecting::load)
        .map_err(anyhow::Error::from_boxed)?;
    let json = json!({
        "pictures": tables::pictures(&detections),
        "mirrored": mirrored.map(path_json),
        "skipped": detecting::skipped_json(&detections),
    });
    for file in &csv {
        files::write(file, tables::csv(&detections).as_bytes())?;
    }
    if let (Some(folder), Some(drawings)) = (&args.output, &drawings) {
        files::write(&folder.join("corners.json"), json.to_string().as_bytes())?;
        for (index, detected) in &readable {
            let mut picture = pictures::load(&paths[*index])?;
            drawing::draw(&mut picture, &detected.found);
            pictures::save(&drawings[*index], picture)?;
        }
    }
    let mut text = text(args, &detections);
    if let Some(file) = mirrored {
        let _ = writeln!(
            text,
            "{}: mirrored: its markers can be read only in a mirror. Switch the mirroring of the camera off",
            file.display()
        );
    }
    Ok(Report::new(text, json))
}

/// `DIR/NAME.png`, numbered where two pictures have the same name.
fn drawing_names(folder: &Path, paths: &[PathBuf]) -> Vec<PathBuf> {
    let mut taken = std::collections::HashSet::new();
    let names = paths.iter().map(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let numbered = (2..).map(|n| format!("{stem}-{n}.png"));
        let name = std::iter::once(format!("{stem}.png")).chain(numbered);
        let free = name.into_iter().find(|name| taken.insert(name.clone()));
        folder.join(free.unwrap_or_default())
    });
    names.collect()
}

fn text(args: &Args, detections: &Detections) -> String {
    let mut text = String::new();
    let readable = detections.readable();
    for (index, detected) in &readable {
        let found = &detected.found;
        let _ = write!(text, "{}:", detections.pictures[*index].file.display());
        if let Some(board) = args.board {
            let _ = match (&found.board, found.other_board) {
                (Some(view), _) => write!(
                    text,
                    " {} of {} corners",
                    view.corners.len(),
                    board.corners()
                ),
                (None, Some(other)) => write!(text, " no {board}, but a board of {other} or more"),
                (None, None) => write!(text, " no board"),
            };
        }
        if args.markers.is_some() {
            let ids: Vec<String> = found
                .markers
                .iter()
                .map(|marker| marker.id.to_string())
                .collect();
            let _ = match &ids[..] {
                [] => write!(text, " no marker"),
                ids => write!(text, " markers {}", ids.join(", ")),
            };
        }
        text.push('\n');
    }
    let founds = || readable.iter().map(|(_, detected)| &detected.found);
    let boards = founds().filter_map(|found| found.board.as_ref());
    let corners: usize = boards.clone().map(|view| view.corners.len()).sum();
    let markers: usize = founds().map(|found| found.markers.len()).sum();
    let _ = writeln!(
        text,
        "{} pictures: {} boards, {corners} corners, {markers} markers",
        readable.len(),
        boards.count(),
    );
    text + &detecting::notes(detections)
}
