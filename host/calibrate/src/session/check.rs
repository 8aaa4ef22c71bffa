//! Sessions in which the board is not the one that was named.

use std::collections::BTreeMap;

use super::{Detected, Found};
use crate::{BoardSize, View};

/// Why the board named is not the one in the pictures.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WrongBoard {
    /// Nothing like a board.
    #[error(
        "no board of {told} inner corners in any of {pictures} pictures. Inner corners are where \
         four squares meet: a board of {squares} squares is a {told}"
    )]
    None {
        /// Size looked for.
        told: BoardSize,
        /// The same in squares.
        squares: String,
        /// Pictures looked at.
        pictures: usize,
    },
    /// The pictures show a board of another size.
    #[error(
        "wrong board: {pictures} of {boards} pictures with a board show {seen} inner corners, not \
         {told}. If that is the board, say --board {seen}"
    )]
    Other {
        /// Size looked for.
        told: BoardSize,
        /// Size seen.
        seen: BoardSize,
        /// Pictures that show just that.
        pictures: usize,
        /// Pictures with any board.
        boards: usize,
    },
}

/// Refuses a session in which no picture shows the board, or most show one of another size.
///
/// # Errors
/// [`WrongBoard`] says what is seen instead.
pub fn check_board(pictures: &[&Detected], told: BoardSize) -> Result<(), WrongBoard> {
    let founds = || pictures.iter().map(|picture| &picture.found);
    let views: Vec<&View> = founds().filter_map(|found| found.board.as_ref()).collect();
    let boards = founds().filter(|found| found.board.is_some() || found.other_board.is_some());
    let boards = boards.count();
    let (seen, count) = most_seen(founds(), told).unwrap_or((told, 0));
    // Half of the boards, and two at least: partly hidden boards differ from picture to picture,
    // and one that reaches farther proves that the others are parts.
    let other = seen != told && (count >= 2 || boards == 1) && 2 * count >= boards;
    if other && !views.iter().any(|view| reaches_beyond(view, seen)) {
        return Err(WrongBoard::Other {
            told,
            seen,
            pictures: count,
            boards,
        });
    }
    if views.is_empty() {
        return Err(WrongBoard::None {
            told,
            squares: format!("{} x {}", told.columns + 1, told.rows + 1),
            pictures: pictures.len(),
        });
    }
    Ok(())
}

/// The size that most pictures show in full, its long side as the long side of `told`.
fn most_seen<'a>(
    founds: impl Iterator<Item = &'a Found>,
    told: BoardSize,
) -> Option<(BoardSize, usize)> {
    let mut counts = BTreeMap::<(u16, u16), usize>::new();
    for found in founds {
        let full = found.board.as_ref().and_then(|view| {
            let extent = extent(view);
            (extent.corners() == view.corners.len()).then_some(extent)
        });
        if let Some(BoardSize { columns, rows }) = found.other_board.or(full) {
            let (long, short) = (columns.max(rows), columns.min(rows));
            let size = if told.columns >= told.rows {
                (long, short)
            } else {
                (short, long)
            };
            *counts.entry(size).or_default() += 1;
        }
    }
    let (&(columns, rows), &count) = counts.iter().max_by_key(|(_, count)| **count)?;
    Some((BoardSize { columns, rows }, count))
}

fn reaches_beyond(view: &View, size: BoardSize) -> bool {
    let extent = extent(view);
    extent.columns.max(extent.rows) > size.columns.max(size.rows)
        || extent.columns.min(extent.rows) > size.columns.min(size.rows)
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

    fn board(columns: u16, rows: u16) -> BoardSize {
        BoardSize { columns, rows }
    }

    fn detected(found: Found) -> Detected {
        Detected {
            sha256: String::new(),
            size_px: [400, 300],
            found,
            resumed: false,
        }
    }

    /// A picture in which `columns` x `rows` corners are found.
    fn full(columns: u16, rows: u16) -> Detected {
        let labels = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
        let corners = labels.map(|(i, j)| Corner {
            i,
            j,
            position_px: [0.0; 2],
            sigma_px: 0.05,
        });
        detected(Found {
            board: Some(View {
                corners: corners.collect(),
            }),
            ..Found::default()
        })
    }

    fn larger(columns: u16, rows: u16) -> Detected {
        detected(Found {
            other_board: Some(board(columns, rows)),
            ..Found::default()
        })
    }

    /// Looks for a 5x4.
    fn check(pictures: &[Detected]) -> Result<(), WrongBoard> {
        check_board(&pictures.iter().collect::<Vec<_>>(), board(5, 4))
    }

    #[test]
    fn the_right_board_passes_whole_or_in_parts() {
        assert_eq!(check(&[full(5, 4), full(4, 5), full(5, 4)]), Ok(()));
        assert_eq!(
            check(&[full(3, 4), full(5, 2), full(4, 4), full(5, 3)]),
            Ok(())
        );
        // Two of three look smaller, the third reaches farther.
        assert_eq!(check(&[full(4, 3), full(4, 3), full(5, 3)]), Ok(()));
        // A larger board somewhere in the background.
        assert_eq!(check(&[full(5, 4), full(5, 4), larger(9, 6)]), Ok(()));
    }

    #[test]
    fn no_board_says_how_boards_are_counted() {
        let message = check(&[detected(Found::default())])
            .unwrap_err()
            .to_string();
        assert!(message.contains("any of 1 pictures") && message.contains("6 x 5 squares"));
    }

    #[test]
    fn a_smaller_board_is_named() {
        let pictures = [full(4, 3), full(4, 3), full(3, 4), full(2, 3)];
        let message = check(&pictures).unwrap_err().to_string();
        assert!(
            message.contains("3 of 4") && message.contains("--board 4x3"),
            "{message}"
        );
    }

    #[test]
    fn a_larger_board_is_named() {
        let pictures = [larger(6, 8), larger(8, 6), full(5, 4), larger(7, 6)];
        let message = check(&pictures).unwrap_err().to_string();
        assert!(
            message.contains("2 of 4") && message.contains("--board 8x6"),
            "{message}"
        );
        let message = check(&[larger(6, 8)]).unwrap_err().to_string();
        assert!(
            message.contains("1 of 1") && message.contains("--board 8x6"),
            "{message}"
        );
    }
}
