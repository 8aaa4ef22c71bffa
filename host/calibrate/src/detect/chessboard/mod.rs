//! Inner corners of a chessboard.

mod candidates;
mod complete;
mod grid;
mod lattice;
mod links;
mod placed;
mod plane;
mod ring;
mod saddle;
#[cfg(test)]
mod tests;

use image::GrayImage;

use crate::board::{BoardSize, Corner, View};
use lattice::Lattice;
use placed::Window;

/// Fewest corners that are a view of a board.
const LEAST_CORNERS: usize = 9;
/// Three corners and the squares around them need more, px.
const LEAST_PICTURE_PX: u32 = 24;
/// Levels of the pyramid have at least this many rows and columns, px.
const LEAST_LEVEL_PX: usize = 60;
/// The largest grids of candidates are tried, this many.
const TRIES: usize = 3;
/// Boards that are looked for in one picture, at most.
const MOST_BOARDS: usize = 12;

/// Why a picture shows no board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BoardMissing {
    /// Nothing like a chessboard.
    #[error("no chessboard found")]
    Nothing,
    /// A chessboard of another size.
    #[error("the board in the picture has {seen} inner corners or more, not {wanted}")]
    OtherSize {
        /// Size that is seen.
        seen: BoardSize,
        /// Size asked for.
        wanted: BoardSize,
    },
}

/// Finds the inner corners of a chessboard, strongly distorted, blurred or partly visible.
///
/// Corners are right or left out: each is fitted to the picture with its edges and must lie where
/// its neighbours say. Labels run from (0, 0); i along the columns, j along the rows, turning as +x
/// turns to +y in the picture. Of a board that is wholly seen and looks different turned round, the
/// square diagonally outside corner (0, 0) is black; see [`View`] for the others.
///
/// # Errors
/// [`BoardMissing`] if there is no board, or one of another size.
pub fn detect(picture: &GrayImage, board: BoardSize) -> Result<View, BoardMissing> {
    let (levels, lattices) = lattices(picture, TRIES);
    let (lattice, window) = lattices
        .into_iter()
        .map(|lattice| {
            let window = placed::window(&lattice, board);
            (lattice, window)
        })
        // The largest in the picture: a monitor may show the board once more.
        .max_by(|(a, in_a), (b, in_b)| a.area_px(in_a).total_cmp(&b.area_px(in_b)))
        .ok_or(BoardMissing::Nothing)?;
    view(&levels[0], lattice, &window, board)
}

/// Finds all boards of a size in a picture, as [`detect`] finds one; that with most corners first.
/// A board that something cuts in two may come as two views.
pub fn detect_all(picture: &GrayImage, board: BoardSize) -> Vec<View> {
    let (levels, lattices) = lattices(picture, MOST_BOARDS);
    let mut views: Vec<View> = Vec::new();
    for lattice in lattices {
        let window = placed::window(&lattice, board);
        let Ok(view) = view(&levels[0], lattice, &window, board) else {
            continue;
        };
        // Two candidates' grids may have grown into the same board.
        let known = |corner: &Corner| views.iter().any(|view| view.is_near(corner.position_px));
        if !view.corners.iter().any(known) {
            views.push(view);
        }
    }
    views.sort_by_key(|view| std::cmp::Reverse(view.corners.len()));
    views
}

impl View {
    /// Whether one of the corners is at a place.
    fn is_near(&self, [x, y]: [f64; 2]) -> bool {
        let places = self.corners.iter().map(|corner| corner.position_px);
        places
            .into_iter()
            .any(|[u, v]| libm::hypot(u - x, v - y) < 2.0)
    }
}

/// The picture's pyramid, and lattices grown from the largest grids of candidates.
fn lattices(picture: &GrayImage, tries: usize) -> (Vec<plane::Plane>, Vec<Lattice>) {
    let levels = plane::pyramid(picture, LEAST_LEVEL_PX);
    if picture.width().min(picture.height()) < LEAST_PICTURE_PX {
        return (levels, Vec::new());
    }
    let candidates = candidates::candidates(&levels);
    let links = links::links(&levels, &candidates);
    let grids = grid::grids(&candidates, &links, LEAST_CORNERS / 2);
    let lattices = grids
        .iter()
        .take(tries)
        .map(|grid| complete::complete(&levels[0], &candidates, grid))
        .filter(|lattice| !lattice.nodes.is_empty())
        .collect();
    (levels, lattices)
}

/// The corners of a lattice that lie on the board.
fn view(
    picture: &plane::Plane,
    mut lattice: Lattice,
    window: &Window,
    board: BoardSize,
) -> Result<View, BoardMissing> {
    if let Some(seen) = placed::larger_board(&lattice, window) {
        return Err(BoardMissing::OtherSize {
            seen,
            wanted: board,
        });
    }
    lattice.nodes.retain(|label, _| window.holds(*label));
    complete::fill_glare(picture, &mut lattice, |label| window.holds(label));
    complete::finish(picture, &mut lattice);
    if lattice.nodes.len() < LEAST_CORNERS {
        return Err(BoardMissing::Nothing);
    }
    let mut corners: Vec<Corner> = placed::on_board(&lattice, window, board)
        .into_iter()
        .map(|(label, (i, j))| Corner {
            i: i as u16,
            j: j as u16,
            position_px: lattice.nodes[&label].saddle.at,
            sigma_px: lattice.nodes[&label].sigma_px,
        })
        .collect();
    corners.sort_by_key(|corner| (corner.j, corner.i));
    Ok(View { corners })
}
