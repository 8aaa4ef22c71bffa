//! Why corners give no camera.

use crate::BoardSize;

/// Why corners give no camera. Each message says what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// Nothing to calibrate from.
    #[error("no picture shows the board: check its size in inner corners, the light and the focus")]
    NoViews,
    /// Fewer views than a calibration needs.
    #[error(
        "{usable} of {given} pictures show enough of the board: at least {needed} are needed, \
         10 or more from different sides are better"
    )]
    TooFewViews {
        /// Views with enough corners.
        usable: usize,
        /// Views given.
        given: usize,
        /// Views needed.
        needed: usize,
    },
    /// A number of the input is not finite or lies outside the picture.
    #[error("picture {view}, corner {corner}: ({x}, {y}) px is no place in the picture")]
    BadCorner {
        /// Index of the view.
        view: usize,
        /// Index of the corner in the view.
        corner: usize,
        /// Position given, px.
        x: f64,
        /// Position given, px.
        y: f64,
    },
    /// Size of a square or of the picture that is none.
    #[error("{what} is {value}: it must be a number above 0")]
    BadSize {
        /// What is at fault.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// More labels along a side than the board has corners.
    #[error(
        "picture {view} shows {columns}x{rows} inner corners, the board has {board}: \
         give the board's real size, and one size to a session"
    )]
    WrongBoard {
        /// Index of the view.
        view: usize,
        /// Columns that the labels span.
        columns: u16,
        /// Rows that the labels span.
        rows: u16,
        /// The board.
        board: BoardSize,
    },
    /// A label twice in one view.
    #[error("picture {view} has two corners labelled ({i}, {j}): detect its corners again")]
    DoubleLabel {
        /// Index of the view.
        view: usize,
        /// Column.
        i: u16,
        /// Row.
        j: u16,
    },
    /// All boards face the same way.
    #[error(
        "all boards are parallel within {spread_deg:.1} degrees, so focal length and distance \
         cannot be told apart: tilt the board by 20 to 40 degrees in several directions"
    )]
    Parallel {
        /// Root mean square angle of the boards' normals from their mean, degrees.
        spread_deg: f64,
    },
    /// All corners lie in one part of the picture.
    #[error(
        "the corners cover {share_percent:.0} % of the picture's area and lie to one side of its \
         centre: show the board all over the picture, up to the rim"
    )]
    OneCorner {
        /// Share of the picture inside the corners' hull, percent.
        share_percent: f64,
    },
    /// Labels run against the picture's handedness.
    #[error(
        "the boards are seen from behind: the pictures are mirrored; switch the mirroring of the \
         camera off"
    )]
    Mirrored,
    /// No lens explains most of the views.
    #[error(
        "no lens fits: {fitting} of {given} pictures agree at best; check that all show the same \
         board, flat, through the same lens at the same zoom and picture size"
    )]
    NoFit {
        /// Views that agree.
        fitting: usize,
        /// Views given.
        given: usize,
    },
    /// Every model that was fitted is refused.
    #[error(
        "none of the lens models that were fitted holds over the corners. {}. Give the radius of the \
         image circle if it is known, another model or degree, or add pictures with the board near the \
         rim",
        .refused.join("; ")
    )]
    NoModel {
        /// Each model and why it is refused.
        refused: Vec<String>,
    },
    /// The corners leave a parameter of the lens open.
    #[error(
        "the corners do not fix the lens: add pictures with the board tilted, and near the rim"
    )]
    Singular,
}
