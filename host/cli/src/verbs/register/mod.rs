//! `tectum register`: pictures that both eyes took at once to a rig whose eyes fit together.

mod distance;
mod summary;

use std::path::PathBuf;

use anyhow::bail;
use clap::ValueEnum;
use tectum_stitch::distance::Toward;
use tectum_stitch::features::Matcher;
use tectum_stitch::session::{
    Input, Options, Pictures, Poses, SeamChoice, SessionError, Step, ToneMatch, WantedDistance,
    html, register_pictures,
};

use crate::args::Size;
use crate::boards::TargetArgs;
use crate::files;
use crate::paired::{self, PairArgs, PairFiles};
use crate::progress::Progress;
use crate::report::Report;

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
    distance: Option<WantedDistance>,
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
    let rig = files::rig(&args.rig)?;
    let paired = args.pairs.paired()?;
    let pictures = paired.files.iter().flatten();
    let pictures = pictures.chain(&args.scene_left).chain(&args.scene_right);
    let outputs = std::iter::once(&args.output).chain(&args.report);
    let inputs = pictures.cloned().chain(files::rig_inputs(&args.rig));
    files::check_outputs(outputs, inputs)?;
    let options = args.options()?;
    let scene = match args.scene_left.is_empty() {
        true => None,
        false => Some(paired::of_files(&args.scene_left, &args.scene_right)?),
    };
    let of_rig = |files| PairFiles { rig: &rig, files };
    let scene = scene.as_ref().map(|scene| of_rig(&scene.files));
    let input = Input {
        rig: &rig,
        rig_file: &args.output,
        pairs: &of_rig(&paired.files),
        scene: scene.as_ref().map(|scene| scene as &dyn Pictures),
    };
    let progress = Progress::new(5);
    let found = register_pictures(&input, &options, &|step| say(&progress, step));
    let found = found.map_err(|error| explain(error, args))?;
    files::write_rig(&found.files)?;
    let mut written: Vec<PathBuf> = found.files.paths().map(PathBuf::from).collect();
    let warnings = summary::warnings(&found);
    if let Some(path) = &args.report {
        files::write(path, html(&found, &warnings).as_bytes())?;
        written.push(path.clone());
    }
    Ok(summary::report(&found, &warnings, &paired.alone, &written))
}

fn say(progress: &Progress, step: Step) {
    match step {
        Step::Matching => progress.step("matching"),
        Step::Pairs(pairs) => progress.more(pairs),
        Step::Pair { pair, of } => progress.step(format!("matching pair {} of {of}", pair + 1)),
        Step::Registering => progress.step("registering"),
        Step::Distance => progress.step("stitch distance"),
        Step::Appearance => progress.step("colours and seam"),
        Step::Stitching => progress.step("table"),
    }
}

/// An error with the arguments that help.
fn explain(error: SessionError, args: &Args) -> anyhow::Error {
    match error {
        SessionError::NoBoardDistance => anyhow::anyhow!(
            "--distance boards needs boards whose corners are matched: give --target or --board"
        ),
        SessionError::OneEye => anyhow::Error::new(error).context(args.rig.display().to_string()),
        error => error.into(),
    }
}

impl Args {
    fn options(&self) -> anyhow::Result<Options> {
        Ok(Options {
            poses: self.poses()?,
            distance: self.distance.unwrap_or(WantedDistance::OfRig),
            toward: self.toward,
            size_px: self.size.0,
            tone: match self.tone {
                ToneName::Match => ToneMatch::Match,
                ToneName::Histogram => ToneMatch::Histogram,
                ToneName::None => ToneMatch::Keep,
            },
            seam: match (self.no_seam, self.no_align) {
                (true, _) => SeamChoice::Geometry,
                (false, true) => SeamChoice::Cut,
                (false, false) => SeamChoice::CutAndBend,
            },
            width_px: self.width,
        })
    }

    /// Refuses what contradicts itself, or says where the poses come from.
    fn poses(&self) -> anyhow::Result<Poses> {
        if self.keep_poses {
            return Ok(Poses::Keep);
        }
        let boards = self.targets.are_given();
        let matcher = match self.matcher {
            Some(MatcherName::Board) if !boards => bail!(
                "--matcher board needs the board: --target FILE.json, or --board 8x6 --square-mm 30"
            ),
            Some(MatcherName::Board) => return self.boards(),
            None if boards => return self.boards(),
            Some(MatcherName::Sift) => Matcher::Sift,
            Some(MatcherName::Rootsift) | None => Matcher::RootSift,
            Some(MatcherName::Orb) => Matcher::Orb,
            Some(MatcherName::Superpoint) => Matcher::SuperPoint,
        };
        Ok(Poses::Features {
            matcher,
            weights: self.weights.clone(),
        })
    }

    fn boards(&self) -> anyhow::Result<Poses> {
        Ok(Poses::Boards(self.targets.targets()?))
    }
}
