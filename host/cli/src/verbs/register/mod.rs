//! `tectum register`: pictures that both eyes took at once to a rig whose eyes fit together.

mod appearance;
mod distance;
mod outputs;
mod page;
mod summary;
mod ties;

use std::path::PathBuf;

use anyhow::bail;
use clap::ValueEnum;
use image::RgbImage;
use tectum_optics::Rig;
use tectum_stitch::distance::Toward;
use tectum_stitch::registration::{Registration, Tie};
use tectum_stitch::seam::Loss;
use tectum_stitch::{Correspondence, Eyes};

use crate::args::Size;
use crate::boards::TargetArgs;
use crate::files;
use crate::paired::{self, PairArgs};
use crate::progress::Progress;
use crate::report::Report;
use appearance::{Appearance, Cost};
use distance::{Distance, Wanted};
use ties::Ties;

/// Pairs whose colours and seam are looked at: more tell nothing new, and each takes a second.
const LOOKED_AT: usize = 12;

/// Pictures that both eyes took at once to a rig whose eyes fit together
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum register rig.toml --left l --right r --target overlap.json -o fish.toml --report fish.html\n  \
    tectum register rig.toml --left l --right r --board 8x6 --square-mm 30 -o fish.toml\n  \
    tectum register rig.toml --left l.png --right r.png --matcher rootsift -o fish.toml\n  \
    tectum register rig.toml --picture both.jpg --keep-poses --distance auto -o fish.toml\n\n\
    The rig's eyes are turned, and with boards their lenses scaled by a little, until both see the\n\
    same points in the same directions: corners of boards (`tectum board` writes the target's JSON\n\
    beside the print), or natural features, for which the eyes must not have turned by more than 10\n\
    degrees. Where the rig's own poses predict natural features as well, they are kept. Then the\n\
    colours are matched, the seam is cut where it shows least, and the eyes are bent towards each\n\
    other along it where that makes it better and the table's mesh carries it. `tectum bake` puts all\n\
    of it into the table. Boards decide how the eyes are turned; the scene to swim in decides seam and\n\
    colours: give pictures of it with --scene-left and --scene-right.\n\n\
    Beside OUT.toml are written pictures that it names: OUT-seam-HASH.png, OUT-tone-HASH.png and\n\
    OUT-warp-HASH.png. All are written before OUT.toml, which is replaced last.")]
pub struct Args {
    /// Rig file to begin with, or a calibration of Kalibr, OpenCV or Basalt with two cameras
    rig: PathBuf,
    #[command(flatten)]
    pairs: PairArgs,
    /// Rig file to write
    #[arg(short, long, value_name = "OUT.toml")]
    output: PathBuf,
    #[command(flatten)]
    targets: TargetArgs,
    /// How points are matched (default: boards if there are any, else rootsift)
    #[arg(long, value_enum, value_name = "NAME")]
    matcher: Option<MatcherName>,
    /// Weights of SuperPoint's network
    #[arg(long, value_name = "FILE.onnx")]
    weights: Option<PathBuf>,
    /// Leave the eyes as the rig has them: colours, seam and alignment only
    #[arg(long, conflicts_with_all = ["target", "board", "matcher"])]
    keep_poses: bool,
    /// Distance at which the pictures are joined, m, `inf`, `boards` (where they stand), or `auto`: as
    /// the pictures have it, if they say so clearly (default: the rig's)
    #[arg(long, value_name = "auto|boards|METRES", value_parser = distance::parse)]
    distance: Option<Wanted>,
    /// Directions whose distance `--distance auto` looks for: yaws in degrees from right to left, or
    /// `all`
    #[arg(long, value_name = "FROM..TO|all", value_parser = distance::parse_toward,
          default_value = "-45..45", allow_hyphen_values = true)]
    toward: Toward,
    /// Pictures of the left eye for colours, seam and bend, where those with the boards only show how
    /// the eyes are turned
    #[arg(long, value_name = "A", num_args = 1.., requires = "scene_right")]
    scene_left: Vec<PathBuf>,
    /// Pictures of the right eye taken with them
    #[arg(long, value_name = "B", num_args = 1.., requires = "scene_left")]
    scene_right: Vec<PathBuf>,
    /// Size of the stitched picture that the rig will be baked for, px
    #[arg(long, value_name = "WxH", default_value = "640x320")]
    size: Size,
    /// How colours are brought together
    #[arg(long, value_enum, default_value_t = ToneName::Match)]
    tone: ToneName,
    /// Leave the seam to geometry: the nearer optical axis wins
    #[arg(long)]
    no_seam: bool,
    /// Bend nothing along the seam
    #[arg(long)]
    no_align: bool,
    /// Width of the pictures in which the seam is sought, px a turn (default: as fine as the eyes see,
    /// 640 to 2048)
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u16).range(256..=8192))]
    width: Option<u16>,
    /// Report to write: one HTML page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatcherName {
    /// Corners of boards
    Board,
    /// SIFT
    Sift,
    /// SIFT with square roots, and once more along the epipolar planes
    Rootsift,
    /// ORB
    Orb,
    /// A network; needs --weights
    Superpoint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ToneName {
    /// Exposure and white balance, robustly, the lens's falloff told apart
    Match,
    /// The paper's: both histograms of the overlap become one
    Histogram,
    /// As they are
    None,
}

/// Registers.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let mut rig = files::rig(&args.rig)?;
    // Found anew below: an earlier bend in the pictures would be measured, but not written.
    rig.stitching = None;
    let plain = rig.clone();
    let outputs = outputs::Outputs::new(args);
    let paired = args.pairs.paired()?;
    let pictures = paired.files.iter().flatten();
    let pictures = pictures.chain(&args.scene_left).chain(&args.scene_right);
    let pictures = pictures.cloned();
    files::check_outputs(
        outputs.named(),
        pictures.chain(files::rig_inputs(&args.rig)),
    )?;
    let progress = Progress::new(5);
    progress.step("matching");
    let (ties, registration) = if args.keep_poses {
        (None, None)
    } else {
        let ties = Ties::find(args, &rig, &paired.files, &progress)?;
        progress.step("registering");
        let registration = ties.register(&rig)?;
        (Some(ties), Some(registration))
    };
    let found = registration.as_ref().map_or(&rig, |found| &found.rig);
    let scenes = match args.scene_left.is_empty() {
        true => None,
        false => Some(paired::of_files(&args.scene_left, &args.scene_right)?),
    };
    let files = scenes
        .as_ref()
        .map_or(&paired.files, |scenes| &scenes.files);
    let every = files.len().div_ceil(LOOKED_AT).max(1);
    let looked_at = files.iter().step_by(every);
    let pictures: anyhow::Result<Vec<Eyes<RgbImage>>> =
        looked_at.map(|files| paired::load(found, files)).collect();
    let pictures = pictures?;
    progress.step("stitch distance");
    let points = ties.as_ref().map_or(&[][..], |ties| &ties.ties);
    let distance = Distance::choose(args.distance, found, &pictures, args.toward, points)?;
    let registered = &distance.rig;
    progress.step("colours and seam");
    let mut appearance = Appearance::find(args, registered, &pictures)?;
    if scenes.is_none() && ties.as_ref().is_some_and(|ties| !ties.outcomes.is_empty()) {
        appearance.warnings.push(
            "Colours, seam and bend come from pictures with boards in them, and the seam goes round \
             these: give pictures of a scene with --scene-left and --scene-right."
                .into(),
        );
    }
    progress.step("writing");
    let (rig, mut written) = outputs.write_rig(registered, &appearance)?;
    let stitched = appearance::stitched(&rig, &pictures[0])?;
    let cost = Cost::of(&plain, &rig, args.size.0)?;
    let loss = loss(&rig, points, &appearance);
    let done = Done {
        args,
        files: &paired.files,
        ties: ties.as_ref(),
        registration: registration.as_ref(),
        distance: &distance,
        appearance: &appearance,
        stitched: &stitched,
        pictures: &pictures,
        every: scenes.is_none().then_some(every),
        cost: &cost,
        loss,
    };
    if let Some(path) = outputs.report() {
        files::write(path, page::html(&done).as_bytes())?;
        written.push(path.to_owned());
    }
    Ok(summary::report(&done, &paired.alone, &written))
}

/// All that was done.
struct Done<'a> {
    args: &'a Args,
    files: &'a [Eyes<PathBuf>],
    ties: Option<&'a Ties>,
    registration: Option<&'a Registration>,
    distance: &'a Distance,
    appearance: &'a Appearance,
    stitched: &'a appearance::Stitched,
    /// What colours and seam come from.
    pictures: &'a [Eyes<RgbImage>],
    /// They are every so many of the shots; `None` if they are others.
    every: Option<usize>,
    cost: &'a Cost,
    loss: Option<Loss>,
}

/// What the seam cuts away and shows twice of the points that were matched, or along the seam.
fn loss(rig: &Rig, ties: &[Tie], found: &Appearance) -> Option<Loss> {
    let seam = rig.stitching.as_ref().and_then(|s| s.seam.as_ref());
    let points: Vec<Correspondence> = ties.iter().map(|tie| tie.pair).collect();
    seam.and_then(|seam| Loss::of_points(rig, seam, &points))
        .or_else(|| Loss::of_parallaxes(found.matches.iter().map(|found| found.parallax_rad)))
}

impl Done<'_> {
    /// Name of a shot.
    fn shot_name(&self, shot: usize) -> String {
        let [left, right] = &self.files[shot];
        let name = |file: &PathBuf| {
            file.file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        };
        match name(left) == name(right) {
            true => name(left),
            false => format!("{} and {}", name(left), name(right)),
        }
    }
}

/// Matches that agree.
fn agreeing(found: &Registration) -> usize {
    found.inliers.iter().filter(|agrees| **agrees).count()
}

impl Args {
    /// Refuses what contradicts itself, or names the way to match.
    fn matcher(&self) -> anyhow::Result<MatcherName> {
        let boards = self.targets.are_given();
        match self.matcher {
            Some(MatcherName::Board) if !boards => bail!(
                "--matcher board needs the board: --target FILE.json, or --board 8x6 --square-mm 30"
            ),
            Some(matcher) => Ok(matcher),
            None if boards => Ok(MatcherName::Board),
            None => Ok(MatcherName::Rootsift),
        }
    }
}
