//! `tectum align`: boards beside the fish say whether the picture's yaw and pitch are right.

mod drawing;
mod summary;

use std::path::PathBuf;

use anyhow::bail;
use clap::ValueEnum;
use image::RgbImage;
use image::imageops::grayscale;
use tectum_bake::output_map;
use tectum_calibrate::BoardSize;
use tectum_optics::design::{OrientationBoard, PitchConvention};
use tectum_optics::{OutputMap, RigFiles, Side};
use tectum_stitch::orientation::{
    Alignment, Correction, OwnScale, Placement, Shot, TurnAbout, align, corrected,
};
use tectum_stitch::session::stitching_pictures;
use tectum_tables::RunKind;

use crate::report::{Report, Usage};
use crate::shown::run_at;
use crate::{detecting, files, pictures};

/// Size of the seam's picture that a turned rig gets, px.
const SEAM_PX: [u16; 2] = [2048, 1024];

/// Boards beside the fish say whether the picture's yaw and pitch are right
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum align fish.tct --rig rig.toml --board-left l.png --board-right r.png \\\n      \
    --board 11x8 --square-mm 35 --distance-mm 160 --origin 2,2 --picture check.png\n  \
    tectum align fish.tct --rig rig.toml --board-left l.png --board-right r.png \\\n      \
    --board 11x8 --square-mm 35 --distance-mm 160 --origin 2,2 -o aligned.toml\n\n\
    A chessboard stands upright beside the fish and parallel to it, its rows level, first on the left,\n\
    then on the right (Tong et al. 2024, Section 4). One of its inner corners, the origin, is level\n\
    with the body's origin and straight out from it, at --distance-mm. Give the stitched picture of\n\
    each. From the origin, corner (i, j) is i squares up and j squares towards the nose, which is a\n\
    yaw and a pitch (Eq. 7, with the sign of Table 2); parallax from the eye's place to the body's\n\
    origin is accounted for.\n\n\
    With -o the rig is written with both eyes turned as the boards say, which calibration of the eyes\n\
    cannot know: as one piece with the body, or each in its place, whichever fits better (--turn\n\
    says). `--correct scale` also bends the picture by the boards' own scale, for\n\
    lenses that are known by their data sheet only. Bake it, and the core pays nothing.")]
pub struct Args {
    /// Table that the pictures were stitched with
    table: PathBuf,
    /// What the table was baked from: rig file, or a calibration of Kalibr, OpenCV or Basalt with two cameras
    #[arg(long, value_name = "RIG.toml")]
    rig: PathBuf,
    /// Stitched pictures with the board on the fish's left
    #[arg(long, value_name = "A", num_args = 1.., required_unless_present = "board_right")]
    board_left: Vec<PathBuf>,
    /// Stitched pictures with the board on its right
    #[arg(long, value_name = "B", num_args = 1..)]
    board_right: Vec<PathBuf>,
    /// Inner corners: from tail to nose x upwards
    #[arg(long, value_name = "11x8", value_parser = detecting::board)]
    board: BoardSize,
    /// Side of a square, measured on the print, mm
    #[arg(long, value_name = "MM")]
    square_mm: f64,
    /// From the body's origin to the board, mm
    #[arg(long, value_name = "MM")]
    distance_mm: f64,
    /// The corner straight out from the body's origin: columns from the tail, rows from below, from 0
    #[arg(long, value_name = "COLUMN,ROW", value_parser = origin)]
    origin: [u16; 2],
    /// Which angle is called pitch
    #[arg(long, value_enum, default_value_t = ConventionName::Elevation)]
    convention: ConventionName,
    /// Rig file to write, put right
    #[arg(short, long, value_name = "OUT.toml")]
    output: Option<PathBuf>,
    /// What turned: the body with both eyes, or each eye in its place (default: what fits the boards
    /// better)
    #[arg(long, value_enum, value_name = "WHAT")]
    turn: Option<TurnName>,
    /// What is put right
    #[arg(long, value_enum, default_value_t = CorrectName::Turn, requires = "output")]
    correct: CorrectName,
    /// Picture to write: the corners and by how much they are off
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ConventionName {
    /// True elevation above the horizontal plane
    Elevation,
    /// The angle in the transverse plane, the same along a row of the board (Table 1)
    Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TurnName {
    /// Both eyes as one piece, their places too
    Body,
    /// Each eye about its own centre
    Eyes,
}

impl From<TurnName> for TurnAbout {
    fn from(name: TurnName) -> Self {
        match name {
            TurnName::Body => Self::Body,
            TurnName::Eyes => Self::Eyes,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CorrectName {
    /// Both eyes turned together
    Turn,
    /// The same, and the picture bent by the boards' own scale
    Scale,
}

impl From<ConventionName> for PitchConvention {
    fn from(name: ConventionName) -> Self {
        match name {
            ConventionName::Elevation => Self::Elevation,
            ConventionName::Paper => Self::Paper,
        }
    }
}

fn origin(text: &str) -> Result<[u16; 2], String> {
    text.split_once(',')
        .and_then(|(column, row)| Some([column.trim().parse().ok()?, row.trim().parse().ok()?]))
        .ok_or_else(|| "needed is COLUMN,ROW, such as 2,2, both from 0".into())
}

/// All that was done.
struct Done<'a> {
    args: &'a Args,
    placement: &'a Placement,
    shots: &'a [Shot],
    pictures: &'a [RgbImage],
    map: &'a OutputMap,
    found: &'a Alignment,
    scale: Option<&'a OwnScale>,
}

/// Aligns.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let geometry_m = OrientationBoard::new(args.distance_mm / 1e3, args.square_mm / 1e3)
        .map_err(|error| Usage(error.to_string()))?;
    let placement = Placement::new(args.board, args.origin, geometry_m)?;
    let rig = files::rig(&args.rig)?;
    let bytes = files::read(&args.table)?;
    let tables = files::table(&bytes, &args.table)?;
    if rig.fingerprint() != tables.rig_fingerprint() {
        bail!(
            "{} was not baked from {}: give the rig that the pictures were stitched with",
            args.table.display(),
            args.rig.display()
        );
    }
    let inputs = args.board_left.iter().chain(&args.board_right);
    let inputs = inputs.chain([&args.table]).cloned();
    files::check_outputs(
        args.output.iter().chain(&args.picture),
        inputs.chain(files::rig_inputs(&args.rig)),
    )?;
    if let Some(path) = &args.picture {
        pictures::format_of(path)?;
    }
    let map = output_map(&tables);
    let sides = [
        (Side::Left, &args.board_left),
        (Side::Right, &args.board_right),
    ];
    let (mut shots, mut stitched) = (Vec::new(), Vec::new());
    for (side, paths) in sides {
        for path in paths {
            let picture = pictures::load(path)?;
            pictures::check_size(
                &picture,
                path,
                map.size_px,
                "a picture stitched with the table",
            )?;
            let name = path.display().to_string();
            shots.push(Shot::detect(name, side, &grayscale(&picture), &placement)?);
            stitched.push(picture);
        }
    }
    let shown_by = |at| match run_at(&tables, at)? {
        RunKind::Left => Some(0),
        RunKind::Right => Some(1),
        RunKind::Blend(_) | RunKind::Void => None,
    };
    let mut found = align(&rig, &map, shown_by, &placement, &shots)?;
    if let Some(about) = args.turn {
        found = found.with_turn(about.into());
    }
    let scale = found.own_scale();
    let done = Done {
        args,
        placement: &placement,
        shots: &shots,
        pictures: &stitched,
        map: &map,
        found: &found,
        scale: scale.as_ref(),
    };
    let mut written = Vec::new();
    if let Some(output) = &args.output {
        let correction = match (args.correct, &scale) {
            (CorrectName::Turn, _) => Correction::Turn,
            (CorrectName::Scale, Some(scale)) => Correction::Scale(scale.clone()),
            (CorrectName::Scale, None) => bail!("the boards' corners give no scale"),
        };
        let right = corrected(&rig, &found, &correction, SEAM_PX)?;
        let pictures =
            stitching_pictures(right.seam_png, right.tone.as_ref(), right.warp.as_ref())?;
        let from = format!("{} and orientation boards", args.rig.display());
        let files = RigFiles::new(&right.rig, pictures, output, &from)?;
        files::write_rig(&files)?;
        written.extend(files.paths().map(PathBuf::from));
    }
    if let Some(path) = &args.picture {
        pictures::save(path, drawing::draw(&done))?;
        written.push(path.clone());
    }
    Ok(summary::report(&done, &written))
}
