//! The stitching job on this machine, which every board must repeat to the byte.

use std::fs;

use anyhow::{Context, anyhow, bail};
use tectum_core::{Eye, Tables};
use tectum_fixture::frames::{self, Layout};
use tectum_fixture::{job, table_file};

use super::board::Board;
use super::repository;

/// Compares the lines a board logged with those of the same job here, snapshot or not.
pub fn check(board: Board, lines: &[String]) -> anyhow::Result<()> {
    let expected = lines_of(board).context("the job on the host")?;
    let differing = expected
        .iter()
        .zip(lines)
        .find(|(host, board)| host != board);
    if let Some((host, board)) = differing {
        bail!("board and host differ:\n  host  {host}\n  board {board}");
    }
    if expected.len() != lines.len() {
        bail!(
            "the board logged {} lines, the host {}",
            lines.len(),
            expected.len()
        );
    }
    Ok(())
}

fn lines_of(board: Board) -> anyhow::Result<Vec<String>> {
    let file = table_file(board.name()).ok_or_else(|| anyhow!("no table for this board"))?;
    let bytes = fs::read(repository().join(file)).with_context(|| format!("reading {file}"))?;
    let tables = Tables::parse(&bytes).with_context(|| format!("checking {file}"))?;
    let pairs = Layout::ALL.map(|layout| {
        [Eye::Left, Eye::Right].map(|eye| {
            let [width, height] = tables.source_size_px(eye).unwrap_or_default();
            frames::bytes(layout, eye as u32, width, height).collect::<Vec<u8>>()
        })
    });
    let pair = |layout: Layout| {
        let [left, right] = &pairs[layout as usize];
        [left.as_slice(), right.as_slice()]
    };
    let pixels = usize::from(tables.output_width_px()) * usize::from(tables.output_height_px());
    let mut room = vec![0; 3 * pixels];
    let mut lines = Vec::new();
    job::run(&tables, pair, &mut room, |line| {
        lines.push(line.to_string())
    })
    .map_err(|error| anyhow!("{error:?}"))?;
    Ok(lines)
}
