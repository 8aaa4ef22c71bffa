//! Registration as a whole: pictures that both eyes took at once, to a rig whose eyes fit together.
//!
//! ```text
//! pictures ─► ties ─► registration ─► distance ─► appearance (colours, seam, bend) ─► RigFiles
//!                                                     baked and stitched (cost, quality) ◄─┘
//! ```
//!
//! Nothing is written: [`Registered::files`] holds the rig and the pictures that it names.

mod appearance;
mod boards;
mod distance;
mod error;
mod page;
mod pictures;
mod stitched;
mod ties;

use std::path::{Path, PathBuf};

use image::RgbImage;
use tectum_calibrate::target::Target;
use tectum_optics::{Rig, RigFiles};

use crate::distance::Toward;
use crate::features::Matcher;
use crate::registration::{Registration, Tie};
use crate::seam::Loss;
use crate::{Correspondence, Eyes};
pub use appearance::{Appearance, SeamChoice, ToneMatch, Warning, stitching_pictures};
pub use boards::{Boards, paired_boards, refused};
pub use distance::{Distance, WantedDistance};
pub use error::SessionError;
pub use page::{html, missed};
pub use pictures::{PictureError, Pictures};
pub use stitched::{Cost, Stitched};
pub use ties::Ties;

/// Pairs whose colours and seam are looked at: more tell nothing new, and each takes a second.
const LOOKED_AT: usize = 12;

/// What is registered.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// Rig to begin with. What its `[stitching]` holds is found anew.
    pub rig: &'a Rig,
    /// File that the rig will be written to: the pictures that it names are named after it.
    pub rig_file: &'a Path,
    /// Pictures that show how the eyes are turned.
    pub pairs: &'a dyn Pictures,
    /// Pictures for colours, seam and bend; `None` takes the same.
    pub scene: Option<&'a dyn Pictures>,
}

/// What is known of the eyes' poses.
#[derive(Debug, Clone)]
pub enum Poses {
    /// They are right.
    Keep,
    /// Boards in the pictures tell.
    Boards(Vec<Target>),
    /// Natural features tell.
    Features {
        /// How they are found.
        matcher: Matcher,
        /// File of the network that finds them, if one does.
        weights: Option<PathBuf>,
    },
}

/// How to register.
#[derive(Debug, Clone)]
pub struct Options {
    /// Where the eyes' poses come from.
    pub poses: Poses,
    /// Where the pictures are joined.
    pub distance: WantedDistance,
    /// Directions whose distance [`WantedDistance::OfPictures`] looks for.
    pub toward: Toward,
    /// Size of the stitched picture that the rig will be baked for, px.
    pub size_px: [u16; 2],
    /// How colours are brought together.
    pub tone: ToneMatch,
    /// What is done where the pictures meet.
    pub seam: SeamChoice,
    /// Width of the pictures in which the seam is sought, px a turn; `None`: as fine as the eyes see.
    pub width_px: Option<u16>,
}

/// What is done next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Points are matched.
    Matching,
    /// So many pairs of pictures will be looked at, a [`Step::Pair`] each.
    Pairs(usize),
    /// Points are matched in a pair of pictures.
    Pair {
        /// Which, from 0.
        pair: usize,
        /// How many there are.
        of: usize,
    },
    /// The eyes are turned.
    Registering,
    /// The stitch distance is chosen.
    Distance,
    /// Colours are matched, the seam is cut, the eyes are bent.
    Appearance,
    /// The rig is baked and stitches a pair.
    Stitching,
}

/// All that was found.
#[derive(Debug, Clone)]
pub struct Registered {
    /// The rig and the pictures that it names, to be written.
    pub files: RigFiles,
    /// Names of the pairs of pictures.
    pub pairs: Vec<String>,
    /// Points in both eyes; `None` if the poses are kept.
    pub ties: Option<Ties>,
    /// What they say of the poses.
    pub registration: Option<Registration>,
    /// Where the pictures are joined.
    pub distance: Distance,
    /// Colours, seam and bend.
    pub appearance: Appearance,
    /// The first pair, as the fish stitches it.
    pub stitched: Stitched,
    /// What colours and seam come from.
    pub pictures: Vec<Eyes<RgbImage>>,
    /// They are every so many of the pairs; `None` if they are of another scene.
    pub every: Option<usize>,
    /// What the table costs.
    pub cost: Cost,
    /// What the seam cuts away and shows twice of the points that were matched, or along the seam.
    pub loss: Option<Loss>,
}

/// Registers. `progress` hears of each step as it begins.
///
/// # Errors
/// [`SessionError`] says what is wrong with the pictures, or why nothing can be made of them.
pub fn register_pictures(
    input: &Input<'_>,
    options: &Options,
    progress: &dyn Fn(Step),
) -> Result<Registered, SessionError> {
    let mut plain = input.rig.clone();
    // Found anew below: an earlier bend in the pictures would be measured, but not written.
    plain.stitching = None;
    progress(Step::Matching);
    let ties = match &options.poses {
        Poses::Keep => None,
        Poses::Boards(targets) => Some(Ties::of_boards(&plain, input.pairs, targets)?),
        Poses::Features { matcher, weights } => {
            let with = (*matcher, weights.as_deref());
            Some(Ties::of_features(&plain, input.pairs, with, progress)?)
        }
    };
    let registration = match &ties {
        None => None,
        Some(ties) => {
            progress(Step::Registering);
            Some(ties.register(&plain)?)
        }
    };
    let found = registration.as_ref().map_or(&plain, |found| &found.rig);
    let shown = input.scene.unwrap_or(input.pairs);
    let every = shown.count().div_ceil(LOOKED_AT).max(1);
    let pictures = looked_at(found, shown, every)?;
    progress(Step::Distance);
    let points = ties.as_ref().map_or(&[][..], |ties| &ties.ties);
    let distance = Distance::choose(options.distance, found, &pictures, options.toward, points)?;
    let registered = &distance.rig;
    progress(Step::Appearance);
    let mut appearance = Appearance::find(options, registered, &pictures)?;
    if input.scene.is_none() && ties.as_ref().is_some_and(|ties| !ties.outcomes.is_empty()) {
        appearance.warnings.push(Warning::BoardsInScene);
    }
    progress(Step::Stitching);
    let from = "pictures that both eyes took at once";
    let files = RigFiles::new(registered, appearance.pictures()?, input.rig_file, from)?;
    let rig = files.rig();
    let stitched = Stitched::of(rig, &pictures[0])?;
    let cost = Cost::of(&plain, rig, options.size_px)?;
    let loss = loss(rig, points, &appearance);
    Ok(Registered {
        pairs: (0..input.pairs.count())
            .map(|pair| input.pairs.name(pair))
            .collect(),
        ties,
        registration,
        distance,
        appearance,
        stitched,
        pictures,
        every: input.scene.is_none().then_some(every),
        cost,
        loss,
        files,
    })
}

impl Registered {
    /// Matches that agree.
    pub fn agreeing(&self) -> Option<usize> {
        let found = self.registration.as_ref()?;
        Some(found.inliers.iter().filter(|agrees| **agrees).count())
    }
}

/// Every so many of the pairs; at least one, and of the sizes of the rig's eyes.
fn looked_at(
    rig: &Rig,
    pictures: &dyn Pictures,
    every: usize,
) -> Result<Vec<Eyes<RgbImage>>, SessionError> {
    let mut looked_at = Vec::new();
    for pair in (0..pictures.count()).step_by(every) {
        let both = pictures.rgb(pair).map_err(SessionError::Picture)?;
        let eyes = [("left", &rig.left), ("right", &rig.right)];
        for ((eye, rig_eye), picture) in eyes.into_iter().zip(&both) {
            let rig_eye = rig_eye.as_ref().ok_or(SessionError::OneEye)?;
            let [width, height] = rig_eye.eye.size_px.map(u32::from);
            if picture.dimensions() != (width, height) {
                let pair = pictures.name(pair);
                return Err(SessionError::Size { pair, eye });
            }
        }
        looked_at.push(both);
    }
    match looked_at.is_empty() {
        true => Err(SessionError::NoPictures),
        false => Ok(looked_at),
    }
}

/// What the seam cuts away and shows twice of the points that were matched, or along the seam.
fn loss(rig: &Rig, ties: &[Tie], found: &Appearance) -> Option<Loss> {
    let seam = rig.stitching.as_ref().and_then(|s| s.seam.as_ref());
    let points: Vec<Correspondence> = ties.iter().map(|tie| tie.pair).collect();
    seam.and_then(|seam| Loss::of_points(rig, seam, &points))
        .or_else(|| Loss::of_parallaxes(found.matches.iter().map(|found| found.parallax_rad)))
}
