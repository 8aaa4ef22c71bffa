//! The black of a target in its own frame: a chessboard's inner corner (0, 0), or a marker's top
//! left corner.

use super::sheet::Rect;
use super::{Marker, Target, TargetError};
use crate::Board;

/// The area of a target with the white that it needs around it: half a square around a board (its
/// outer corners are not used), a module around a marker.
pub(super) fn outline(target: &Target) -> Result<Rect, TargetError> {
    Ok(match target {
        Target::Chessboard(board) => board_outline(board),
        Target::Marker(marker) => marker_outline(marker, [0.0; 2])?,
        Target::Overlap(overlap) => board_outline(&overlap.board).around(&marker_outline(
            &overlap.marker(),
            overlap.marker_origin_mm,
        )?),
    })
}

/// What is black; no two rectangles overlap.
pub(super) fn ink(target: &Target) -> Result<Vec<Rect>, TargetError> {
    Ok(match target {
        Target::Chessboard(board) => squares(board),
        Target::Marker(marker) => modules(marker, [0.0; 2])?,
        Target::Overlap(overlap) => {
            let mut ink = squares(&overlap.board);
            ink.extend(modules(&overlap.marker(), overlap.marker_origin_mm)?);
            ink
        }
    })
}

/// Where along x and along y black may begin or end, rising.
pub(super) fn edges(target: &Target) -> Result<[Vec<f64>; 2], TargetError> {
    let mut edges = [vec![], vec![]];
    if let Target::Chessboard(board) | Target::Overlap(super::OverlapTarget { board, .. }) = target
    {
        let size = board.size;
        for (edges, corners) in edges.iter_mut().zip([size.columns, size.rows]) {
            edges.extend((-1..=i32::from(corners)).map(|k| f64::from(k) * board.square_mm));
        }
    }
    let marker = match target {
        Target::Chessboard(_) => None,
        Target::Marker(marker) => Some((marker.clone(), [0.0; 2])),
        Target::Overlap(overlap) => Some((overlap.marker(), overlap.marker_origin_mm)),
    };
    if let Some((marker, origin)) = marker {
        let module = marker.module_mm()?;
        for (edges, start) in edges.iter_mut().zip(origin) {
            edges.extend((0..=marker.modules()?).map(|k| start + k as f64 * module));
        }
    }
    for edges in &mut edges {
        edges.sort_by(f64::total_cmp);
    }
    Ok(edges)
}

fn board_outline(board: &Board) -> Rect {
    let s = board.square_mm;
    let squares = [board.size.columns, board.size.rows].map(|n| f64::from(n + 1) * s);
    Rect::new([-s, -s], squares).grown(s / 2.0)
}

fn marker_outline(marker: &Marker, origin_mm: [f64; 2]) -> Result<Rect, TargetError> {
    Ok(Rect::new(origin_mm, [marker.side_mm; 2]).grown(marker.module_mm()?))
}

fn squares(board: &Board) -> Vec<Rect> {
    let s = board.square_mm;
    let cells = (0..=board.size.rows).flat_map(|j| (0..=board.size.columns).map(move |i| (i, j)));
    let black = cells.filter(|(i, j)| (i + j) % 2 == 0);
    let place = |k: u16| (f64::from(k) - 1.0) * s;
    black
        .map(|(i, j)| Rect::new([place(i), place(j)], [s, s]))
        .collect()
}

/// A marker's black, a rectangle a run of modules in a row.
fn modules(marker: &Marker, origin_mm: [f64; 2]) -> Result<Vec<Rect>, TargetError> {
    let (n, black, module) = (marker.modules()?, marker.black()?, marker.module_mm()?);
    let mut ink = vec![];
    for y in 0..n {
        let mut x = 0;
        while x < n {
            let run = (x..n).take_while(|x| black(*x, y)).count();
            if run > 0 {
                let at = [0, 1].map(|k| origin_mm[k] + [x, y][k] as f64 * module);
                ink.push(Rect::new(at, [run as f64 * module, module]));
            }
            x += run.max(1);
        }
    }
    Ok(ink)
}
