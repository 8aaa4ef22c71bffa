//! Boards that both eyes see, as the command line names them.

use std::path::{Path, PathBuf};

use anyhow::Context;
use tectum_calibrate::target::{Target, TargetFile};
use tectum_calibrate::{Board, BoardSize};

use crate::{detecting, files};

/// A board as the command line names it: by its size, or by the file beside its print.
#[derive(Debug, Clone, Copy)]
pub struct PrintedBoard {
    /// Inner corners.
    pub size: BoardSize,
    /// Side of a square as it was to be printed, mm, if the file says.
    pub square_mm: Option<f64>,
}

/// `8x6`, or a file of `tectum board` that holds one board.
pub fn printed(text: &str) -> Result<PrintedBoard, String> {
    let is_file = Path::new(text)
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    if !is_file {
        let size = detecting::board(text)?;
        return Ok(PrintedBoard {
            size,
            square_mm: None,
        });
    }
    let file = targets_of(Path::new(text)).map_err(|error| format!("{error:#}"))?;
    let board = |target: &Target| match target {
        Target::Chessboard(board) => Some(*board),
        Target::Overlap(target) => Some(target.board),
        Target::Marker(_) => None,
    };
    let mut boards: Vec<Board> = file.iter().filter_map(board).collect();
    boards.dedup();
    match boards[..] {
        [board] => Ok(PrintedBoard {
            size: board.size,
            square_mm: Some(board.square_mm),
        }),
        _ => Err(format!(
            "it holds {} different boards: say the one in the pictures as 8x6, and --square-mm",
            boards.len()
        )),
    }
}

fn targets_of(path: &Path) -> anyhow::Result<Vec<Target>> {
    let text = String::from_utf8(files::read(path)?)
        .with_context(|| format!("{}: not a text", path.display()))?;
    let file = TargetFile::from_json(&text);
    Ok(file.with_context(|| path.display().to_string())?.targets)
}

/// Boards to look for.
#[derive(clap::Args)]
pub struct TargetArgs {
    /// Boards and markers in the pictures, as `tectum board` describes them
    #[arg(long, value_name = "FILE.json", conflicts_with = "board")]
    target: Option<PathBuf>,
    /// Inner corners of a chessboard without a marker, columns x rows
    #[arg(long, value_name = "8x6", value_parser = detecting::board, requires = "square_mm")]
    board: Option<BoardSize>,
    /// Side of its squares, measured on the print, mm
    #[arg(long, value_name = "MM", requires = "board")]
    square_mm: Option<f64>,
}

impl TargetArgs {
    /// Whether there are any.
    pub fn are_given(&self) -> bool {
        self.target.is_some() || self.board.is_some()
    }

    /// The targets.
    pub fn targets(&self) -> anyhow::Result<Vec<Target>> {
        if let Some(path) = &self.target {
            return targets_of(path);
        }
        let (Some(size), Some(square_mm)) = (self.board, self.square_mm) else {
            return Ok(Vec::new());
        };
        let board = Target::Chessboard(Board { size, square_mm });
        board.check()?;
        Ok(vec![board])
    }
}
