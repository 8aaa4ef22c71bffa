//! What makes a session useless whatever the solver would make of it.

use std::collections::BTreeMap;

use crate::{BoardSize, View};

/// Why a session gives no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BadSession {
    /// Nothing to start from.
    #[error(
        "no board of {board} inner corners in any of {pictures} pictures. Inner corners are where \
         four squares meet: a board of {squares} squares is a {board}"
    )]
    NoBoard {
        /// Board looked for.
        board: BoardSize,
        /// The same in squares.
        squares: String,
        /// Pictures looked at.
        pictures: usize,
    },
    /// The pictures show another board.
    #[error(
        "wrong board: {pictures} of {boards} boards found have exactly {seen} inner corners and \
         none has {told}. If the board is {seen}, say --board {seen}"
    )]
    OtherBoard {
        /// Size looked for.
        told: BoardSize,
        /// Size seen.
        seen: BoardSize,
        /// Pictures that show just that.
        pictures: usize,
        /// Pictures with a board.
        boards: usize,
    },
}

/// Refuses a session in which no picture shows the board, or all show another one.
///
/// `views` are those of the pictures that show a board, `pictures` counts all that could be read.
///
/// # Errors
/// [`BadSession`] says what is wrong and what to do.
pub fn check_views(views: &[&View], pictures: usize, board: BoardSize) -> Result<(), BadSession> {
    if views.is_empty() {
        return Err(BadSession::NoBoard {
            board,
            squares: format!("{} x {}", board.columns + 1, board.rows + 1),
            pictures,
        });
    }
    check_board(views, board)
}

/// A size that is seen in full again and again, and nothing beyond it, is the board's size.
fn check_board(views: &[&View], told: BoardSize) -> Result<(), BadSession> {
    let mut counts = BTreeMap::<(u16, u16), usize>::new();
    for view in views {
        let extent = extent(view);
        let full = extent.corners() == view.corners.len();
        // The long side as the long side of what was told.
        let (mut columns, mut rows) = (extent.columns, extent.rows);
        if (columns > rows) != (told.columns > told.rows) {
            (columns, rows) = (rows, columns);
        }
        if full {
            *counts.entry((columns, rows)).or_default() += 1;
        }
    }
    let Some((&(columns, rows), &pictures)) = counts.iter().max_by_key(|(_, count)| **count) else {
        return Ok(());
    };
    let seen = BoardSize { columns, rows };
    let beyond = |view: &&View| {
        let extent = extent(view);
        extent.columns.max(extent.rows) > columns.max(rows)
            || extent.columns.min(extent.rows) > columns.min(rows)
    };
    // Half of the boards, and two at least: partly hidden boards differ from picture to picture.
    if seen == told || pictures < 2 || 2 * pictures < views.len() || views.iter().any(beyond) {
        return Ok(());
    }
    Err(BadSession::OtherBoard {
        told,
        seen,
        pictures,
        boards: views.len(),
    })
}

fn extent(view: &View) -> BoardSize {
    let side = |label: fn(&crate::Corner) -> u16| {
        let labels = view.corners.iter().map(label);
        let range = labels.clone().min().zip(labels.max());
        range.map_or(0, |(least, most)| most - least + 1)
    };
    BoardSize {
        columns: side(|corner| corner.i),
        rows: side(|corner| corner.j),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Corner;

    const BOARD: BoardSize = BoardSize {
        columns: 5,
        rows: 4,
    };

    /// A board of `columns` x `rows` corners, 20 px apart, from a corner of the image.
    fn view([x, y]: [f64; 2], columns: u16, rows: u16) -> View {
        let labels = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
        View {
            corners: labels
                .map(|(i, j)| Corner {
                    i,
                    j,
                    position_px: [x + 20.0 * f64::from(i), y + 20.0 * f64::from(j)],
                    sigma_px: 0.05,
                })
                .collect(),
        }
    }

    fn check(views: &[View]) -> Result<(), BadSession> {
        let views: Vec<_> = views.iter().collect();
        check_views(&views, 9, BOARD)
    }

    #[test]
    fn sound_views_pass() {
        let views = [[10.0, 10.0], [300.0, 10.0], [200.0, 200.0]].map(|at| view(at, 5, 4));
        assert_eq!(check(&views), Ok(()));
        // Partly hidden boards of many sizes are no other board.
        let partial = [(3, 4), (5, 2), (4, 4), (5, 3)].map(|(c, r)| view([180.0, 130.0], c, r));
        assert_eq!(check(&partial), Ok(()));
    }

    #[test]
    fn no_board_says_how_boards_are_counted() {
        let message = check(&[]).unwrap_err().to_string();
        assert!(message.contains("any of 9 pictures") && message.contains("6 x 5 squares"));
    }

    #[test]
    fn another_board_is_named() {
        let mut views = vec![view([180.0, 130.0], 4, 3), view([10.0, 10.0], 4, 3)];
        // Turned a quarter.
        views.push(view([300.0, 200.0], 3, 4));
        views.push(view([200.0, 200.0], 2, 3));
        let message = check(&views).unwrap_err().to_string();
        assert!(
            message.contains("3 of 4 boards") && message.contains("--board 4x3"),
            "{message}"
        );
        // One board that reaches farther proves that the others are parts.
        views.push(view([100.0, 100.0], 5, 3));
        assert_eq!(check(&views), Ok(()));
    }
}
