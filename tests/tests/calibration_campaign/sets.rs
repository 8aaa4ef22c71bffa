//! Corners of the real sets, detected once and kept in the target folder.

use std::path::Path;

use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::session::{Found, Session, Wanted, list};
use tectum_calibrate::solve::{Options, Problem};
use tectum_calibrate::{Board, View};

/// Folder, board, and whether a mirror shows the board reversed.
const SETS: [(&str, &str, bool); 11] = [
    ("ocam-fisheye1/images", "8x6", false),
    ("ocam-ladybug/images", "8x5", false),
    ("ocam-vmr/images", "7x6", true),
    ("ocam-kaidan/images", "7x11", true),
    ("stereo-fisheye-opencv/left", "8x6", false),
    ("stereo-fisheye-opencv/right", "8x6", false),
    ("camodocal-car-fisheye/images", "9x6", false),
    ("gopro-derlunz/images", "15x9", false),
    ("svs-fisheye-dyfcalid/board", "7x6", false),
    ("t265-air-underwater/air", "7x5", false),
    ("t265-air-underwater/underwater", "7x5", false),
];

/// A real set.
pub struct Set {
    /// Its folder.
    pub name: &'static str,
    /// All boards found.
    pub problem: Problem,
    /// How it is calibrated.
    pub options: Options,
}

impl Set {
    /// Some of its boards.
    pub fn part(&self, indices: &[usize]) -> Problem {
        let views = indices.iter().map(|i| self.problem.views[*i].clone());
        Problem {
            views: views.collect(),
            ..self.problem.clone()
        }
    }
}

/// The real sets whose name contains `part`; none, with a word, where they are absent.
pub fn real(part: &str) -> Vec<Set> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    if !data.is_dir() {
        println!("skipped: no real pictures in {}", data.display());
        return Vec::new();
    }
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("calibration-corners");
    let wanted = SETS.into_iter().filter(|(name, ..)| name.contains(part));
    let sets = wanted.map(|(name, board, mirrored_labels)| {
        let size = board.parse().expect("a board");
        let wanted = Wanted {
            board: Some(size),
            markers: None,
        };
        let session = Session::open(wanted, Some(kept.clone())).expect("a session");
        let files = list(&[data.join(name)]).expect("pictures");
        let look = |picture: &_| Found {
            board: detect(picture, size).ok(),
            ..Found::default()
        };
        let found = session.detect(&files, look, |_| {}).expect("detections");
        let detected = || {
            found
                .pictures
                .iter()
                .filter_map(|picture| picture.detected())
        };
        let views: Vec<View> = detected().filter_map(|d| d.found.board.clone()).collect();
        let problem = Problem {
            size_px: detected().next().expect("a picture").size_px,
            board: Board {
                size,
                square_mm: 30.0,
            },
            views,
        };
        let options = Options {
            mirrored_labels,
            ..Options::default()
        };
        Set {
            name,
            problem,
            options,
        }
    });
    sets.collect()
}
