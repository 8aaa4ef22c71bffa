//! `tectum calibrate`: board pictures to an eye.

mod exports;
mod outputs;
mod shots;
mod stereo;
mod summary;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use tectum_calibrate::session::{CalibratedShots, list};
use tectum_calibrate::solve::{self, Options};
use tectum_calibrate::{Board, Dictionary};
use tectum_optics::Medium;

use crate::boards::{self, PrintedBoard};
use crate::files;
use crate::report::{Report, Usage};

/// Pictures of a chessboard to a calibrated eye
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum calibrate session --board 8x6 --square-mm 30 -o eye.toml --report report.html\n  \
    tectum calibrate near far --board 8x6 --square-mm 30 -o left.toml --medium water\n  \
    tectum calibrate session --board 8x6 --square-mm 30 -o eye.toml \\\n      \
    --calib-results calib_results.txt --opencv opencv.yml --kalibr camchain.yaml\n  \
    tectum calibrate --left l --right r --board board.json -o rig.toml --kalibr camchain.yaml\n\n\
    A board is told by its inner corners, columns x rows: 9 x 7 squares are 8x6. 10 pictures or\n\
    more, the board tilted every way and out to the edge of the image. The lens is OCamCalib's\n\
    polynomial, its degree chosen on pictures held out, unless another model predicts those surely\n\
    better; every model that was fitted is listed with its score. OpenCV and Kalibr files hold a Kannala-Brandt lens fitted to the same\n\
    corners.\n\n\
    What is found in each picture is kept at once, in OUT.session beside the output: an\n\
    interrupted run goes on where it ended, and more pictures cost only themselves.\n\
    The eye's file goes into a rig as `[left]` with `file = \"eye.toml\"`; its field_deg is what the\n\
    boards have covered, and a field_deg in the rig goes before it.")]
pub struct Args {
    /// Folders of pictures, or pictures, of one eye
    #[arg(required_unless_present = "left", value_name = "FOLDER")]
    pictures: Vec<PathBuf>,
    /// Folder of the left eye's pictures, for both eyes: pairs have the same name, or the same last
    /// number in it; writes OUT-left.toml and OUT-right.toml, and the rig to OUT.toml
    #[arg(
        long,
        value_name = "DIR",
        requires = "right",
        conflicts_with = "pictures"
    )]
    left: Option<PathBuf>,
    /// Folder of the right eye's pictures
    #[arg(long, value_name = "DIR", requires = "left")]
    right: Option<PathBuf>,
    /// Inner corners of the chessboard, columns x rows, or the .json that `tectum board` wrote beside the
    /// print
    #[arg(long, value_name = "8x6", value_parser = boards::printed)]
    board: PrintedBoard,
    /// Side of a square, measured on the print, mm (default with a .json: as it was to be printed)
    #[arg(long, value_name = "MM", value_parser = square_mm)]
    square_mm: Option<f64>,
    /// Eye file to write; with both eyes the rig's file, beside OUT-left.toml and OUT-right.toml
    #[arg(short, long, value_name = "EYE.toml")]
    output: PathBuf,
    /// Report to write: one HTML page, of both eyes where both are calibrated
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// OCamCalib's file to write; with both eyes FILE-left.txt and FILE-right.txt
    #[arg(long, value_name = "FILE.txt")]
    calib_results: Option<PathBuf>,
    /// OpenCV's file to write (cv::fisheye; with both eyes K1, D1, K2, D2, and R, T from the left into
    /// the right camera, T in mm)
    #[arg(long, value_name = "FILE.yml")]
    opencv: Option<PathBuf>,
    /// Kalibr's file to write (pinhole, equidistant; with both eyes cam0 is the left one, and T_cn_cnm1
    /// maps from it into the right one's frame)
    #[arg(long, value_name = "FILE.yaml")]
    kalibr: Option<PathBuf>,
    /// Model of the eye's lens (default: the one that predicts pictures held out best)
    #[arg(long, value_enum)]
    model: Option<ModelName>,
    /// Degree of the polynomial (default: chosen on pictures held out)
    #[arg(long, value_name = "N")]
    degree: Option<usize>,
    /// Keep the lens on its axis: OCamCalib's own model, without decentring
    #[arg(long)]
    no_decentring: bool,
    /// With both eyes: distance at which the rig's stitched pictures are to be exact, m (default:
    /// `inf`, where nearer things are doubled or cut by their parallax)
    #[arg(long, value_name = "M", requires = "left", value_parser = stitch_distance_m)]
    stitch_distance: Option<f64>,
    /// What the pictures were taken in
    #[arg(long, value_enum, default_value_t = MediumName::Air)]
    medium: MediumName,
    /// Full field of the lens as its maker states it, degrees: what coverage is judged by
    /// (default: seen in the pictures)
    #[arg(long, value_name = "DEG", value_parser = field_deg)]
    field_deg: Option<f64>,
    /// Dictionary of markers beside the board: mirrored pictures are told by them
    #[arg(long, value_name = "NAME")]
    markers: Option<Dictionary>,
    /// Folder that keeps the detections (default: OUT.session beside the output)
    #[arg(long, value_name = "DIR")]
    session: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModelName {
    /// Polynomial of OCamCalib
    Ocam,
    /// OpenCV's fisheye model
    KannalaBrandt,
    /// Double sphere
    DoubleSphere,
}

impl From<ModelName> for solve::Model {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Ocam => Self::Ocam,
            ModelName::KannalaBrandt => Self::KannalaBrandt,
            ModelName::DoubleSphere => Self::DoubleSphere,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MediumName {
    Air,
    Water,
}

impl From<MediumName> for Medium {
    fn from(name: MediumName) -> Self {
        match name {
            MediumName::Air => Self::Air,
            MediumName::Water => Self::Water,
        }
    }
}

fn square_mm(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok();
    parsed
        .filter(|mm: &f64| (0.01..=10_000.0).contains(mm))
        .ok_or_else(|| "needed is a length in mm, 0.01 to 10000".into())
}

fn stitch_distance_m(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok();
    parsed
        .filter(|metres: &f64| *metres > 0.0)
        .ok_or_else(|| "needed is a distance in m above 0, or inf".into())
}

fn field_deg(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok();
    parsed
        .filter(|deg: &f64| *deg > 0.0 && *deg <= 358.0)
        .ok_or_else(|| "needed is a full angle in degrees, above 0, at most 358".into())
}

/// Calibrates one eye.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let board = args.board()?;
    if let (Some(left), Some(right)) = (&args.left, &args.right) {
        return stereo::run(args, board, [left, right]);
    }
    files::check_outputs(args.outputs(), list(&args.pictures)?)?;
    let shots = shots::take(args, board, &args.pictures)?;
    let found = shots::kept(args, &shots);
    let kept = |error| shots::and_kept(&found, error);
    let eye = CalibratedShots::new(&shots, &args.options());
    let eye = eye.map_err(|error| kept(error.into()))?;
    outputs::write(args, &eye).map_err(kept)?;
    summary::report(args, &eye)
}

impl Args {
    /// All files to write.
    fn outputs(&self) -> impl Iterator<Item = &Path> {
        let others = [
            &self.report,
            &self.calib_results,
            &self.opencv,
            &self.kalibr,
        ];
        let others = others.into_iter().flatten();
        std::iter::once(&self.output)
            .chain(others)
            .map(|path| &**path)
    }

    /// The board in the pictures. A square that nobody has measured is told.
    fn board(&self) -> Result<Board, Usage> {
        let square_mm = match (self.square_mm, self.board.square_mm) {
            (Some(measured_mm), _) => measured_mm,
            (None, Some(square_mm)) => {
                files::note(&format!(
                    "squares of {square_mm} mm, as they were to be printed: printers scale. Measure the \
                     print and say --square-mm"
                ));
                square_mm
            }
            (None, None) => {
                let needed = "--square-mm is needed: the side of a square, measured on the print";
                return Err(Usage(needed.into()));
            }
        };
        Ok(Board {
            size: self.board.size,
            square_mm,
        })
    }

    fn options(&self) -> Options {
        Options {
            model: self.model.map(Into::into),
            degree: self.degree,
            decentring: !self.no_decentring,
            ..Options::default()
        }
    }

    fn session_folder(&self) -> PathBuf {
        let beside = || self.output.with_extension("session");
        self.session.clone().unwrap_or_else(beside)
    }
}
