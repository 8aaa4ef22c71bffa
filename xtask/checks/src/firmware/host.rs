//! The stitching job on this machine, which every board must repeat to the byte.

use std::fmt::Display;
use std::fs;

use anyhow::{Context, anyhow, bail};
use tectum_core::{Eye, Tables};
use tectum_fixture::frames::{self, Layout};
use tectum_fixture::job::JobError;
use tectum_fixture::{job, overlay, queries, scaled_table_file, table_file, tone, toned};

use super::board::Board;
use xtask::repository;

/// What a program should log, for those that this machine can repeat.
pub fn lines(board: Board, program: &str) -> anyhow::Result<Option<Vec<String>>> {
    if !["stitch", "tone", "overlay", "lookup"].contains(&program) {
        return Ok(None);
    }
    let file = match program {
        "overlay" => scaled_table_file(board.name()),
        _ => table_file(board.name()),
    };
    let file = file.ok_or_else(|| anyhow!("no table for this board"))?;
    let bytes = fs::read(repository().join(file)).with_context(|| format!("reading {file}"))?;
    let tables = Tables::parse(&bytes).with_context(|| format!("checking {file}"))?;
    match program {
        "stitch" => on_frames(&tables, |frames, room, log| {
            job::run(&tables, frames, room, log)
        }),
        "tone" => {
            let bytes = toned(&bytes).context("toning the table")?;
            let tables = Tables::parse(&bytes).context("the toned table")?;
            on_frames(&tables, |frames, room, log| {
                tone::run(&tables, frames, room, log)
            })
        }
        "overlay" => on_frames(&tables, |frames, room, log| {
            overlay::run(&tables, frames, room, log)
        }),
        _ => lookup(&tables),
    }
    .map(Some)
}

/// Compares the lines a board logged with those of the host, snapshot or not.
pub fn compare(host: &[String], board: &[String]) -> anyhow::Result<()> {
    if let Some((host, board)) = host.iter().zip(board).find(|(host, board)| host != board) {
        bail!("board and host differ:\n  host  {host}\n  board {board}");
    }
    if host.len() != board.len() {
        bail!(
            "the board logged {} lines, the host {}",
            board.len(),
            host.len()
        );
    }
    Ok(())
}

fn lookup(tables: &Tables) -> anyhow::Result<Vec<String>> {
    let mut lines = Vec::new();
    queries::run(tables, |line| lines.push(line.to_string()));
    Ok(lines)
}

/// A job on frames given by layout, with room for a picture and a log.
fn on_frames(
    tables: &Tables,
    job: impl for<'a> Fn(
        &dyn Fn(Layout) -> [&'a [u8]; 2],
        &mut [u8],
        &mut dyn FnMut(&dyn Display),
    ) -> Result<(), JobError>,
) -> anyhow::Result<Vec<String>> {
    let frame = |layout, eye| {
        let [width, height] = tables.source_size_px(eye).unwrap_or_default();
        frames::bytes(layout, eye as u32, width, height).collect::<Vec<u8>>()
    };
    let pairs = Layout::ALL.map(|layout| [Eye::Left, Eye::Right].map(|eye| frame(layout, eye)));
    let pair = |layout: Layout| {
        let [left, right] = &pairs[layout as usize];
        [left.as_slice(), right.as_slice()]
    };
    let pixels = usize::from(tables.output_width_px()) * usize::from(tables.output_height_px());
    let mut room = vec![0; 3 * pixels];
    let mut lines = Vec::new();
    let mut log = |line: &dyn Display| lines.push(line.to_string());
    job(&pair, &mut room, &mut log).map_err(|error| anyhow!("the job on the host: {error:?}"))?;
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_differing_or_missing_line_is_noticed() {
        let host = ["a 1".to_string(), "b 2".to_string()];
        assert!(compare(&host, &host).is_ok());
        assert!(compare(&host, &["a 1".to_string(), "b 3".to_string()]).is_err());
        assert!(compare(&host, &host[..1]).is_err());
        assert!(compare(&host[..1], &host).is_err());
    }
}
