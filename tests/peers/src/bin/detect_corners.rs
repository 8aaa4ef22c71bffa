//! Finds the inner corners of a chessboard, in the format of a bench of other programs.
//!
//! usage: `detect_corners IMAGE COLUMNS ROWS`
//!
//! Prints `[[x, y], ...]`, by rows where the board is complete (x right, y down, 0-based centres).

use anyhow::Context;
use tectum_calibrate::detect::chessboard::detect;

fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, columns, rows] = &args[..] else {
        anyhow::bail!("usage: detect_corners IMAGE COLUMNS ROWS");
    };
    let board = format!("{columns}x{rows}").parse()?;
    let picture = image::open(file).with_context(|| file.clone())?.to_luma8();
    let view = detect(&picture, board).unwrap_or_default();
    let places: Vec<_> = view
        .corners
        .iter()
        .map(|corner| corner.position_px)
        .collect();
    println!("{}", serde_json::to_string(&places)?);
    Ok(())
}
