//! `cargo xtask firmware report`: the measured figures as a table.

use std::fs;
use std::path::Path;

use clap::ValueEnum;
use serde_json::{Value, json};

use super::board::Board;
use super::{snapshot, workspace};

/// Arguments of `cargo xtask firmware report`.
#[derive(clap::Args)]
pub struct Args {
    /// One JSON object in place of the Markdown tables
    #[arg(long)]
    json: bool,
}

/// A figure: what was measured, its value on each board, and the unit.
struct Row {
    what: String,
    values: Vec<f64>,
    unit: String,
}

/// Prints the figures of all boards.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let rows = rows()?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&as_json(&rows))?);
    } else {
        print!("{}", as_markdown(&rows));
    }
    Ok(())
}

fn rows() -> anyhow::Result<Vec<Row>> {
    let programs = workspace().join("src/bin");
    let proofs = workspace().join("proofs");
    let mut rows = Vec::new();
    for (folder, name) in [
        (&programs, "counts"),
        (&programs, "stack"),
        (&proofs, "size"),
    ] {
        rows.append(&mut rows_of(folder, name)?);
    }
    Ok(rows)
}

/// Figures of one snapshot, on all boards. The lines read "what value unit".
fn rows_of(folder: &Path, name: &str) -> anyhow::Result<Vec<Row>> {
    let mut rows: Vec<Row> = Vec::new();
    for board in Board::value_variants() {
        let text = fs::read_to_string(snapshot::path(folder, name, board.name()))?;
        for line in text.lines().skip(1) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [what @ .., value, unit] = words.as_slice() else {
                continue;
            };
            let what = format!("{name}: {}", what.join(" "));
            let value: f64 = value.parse()?;
            match rows.iter_mut().find(|row| row.what == what) {
                Some(row) => row.values.push(value),
                None => rows.push(Row {
                    what,
                    values: vec![value],
                    unit: unit.to_string(),
                }),
            }
        }
    }
    Ok(rows)
}

fn as_json(rows: &[Row]) -> Value {
    let boards = Board::value_variants();
    rows.iter()
        .map(|row| {
            let values = boards.iter().zip(&row.values);
            let values: Value = values
                .map(|(b, v)| (b.name().to_string(), json!(v)))
                .collect();
            (
                row.what.clone(),
                json!({ "unit": row.unit, "boards": values }),
            )
        })
        .collect()
}

fn as_markdown(rows: &[Row]) -> String {
    let mut text = String::from("| figure | Cortex-M4 | Cortex-M7 | Cortex-M55 | unit |\n");
    text.push_str("|---|---:|---:|---:|---|\n");
    for row in rows {
        let values: Vec<String> = row.values.iter().map(f64::to_string).collect();
        text.push_str(&format!(
            "| {} | {} | {} |\n",
            row.what,
            values.join(" | "),
            row.unit
        ));
    }
    text
}

/// What the README shows of the figures.
const CHOSEN: [&str; 6] = [
    "counts: gray8 bilinear one-eye",
    "counts: yuyv bilinear one-eye",
    "counts: lookup direction of output pixel",
    "stack: yuyv bilinear",
    "size: gray8",
    "size: yuyv",
];

/// Tables of figures, as Markdown.
pub struct Figures {
    /// Those that `docs/firmware.md` shows.
    pub all: String,
    /// Those that the README shows.
    pub chosen: String,
}

/// The figures that the documents show.
pub fn figures() -> anyhow::Result<Figures> {
    let shown = |row: &Row| {
        let what = row.what.as_str();
        // A void pixel is a fill, and a whole picture a mixture: the page shows the parts. Formats
        // that have known bytes in other places cost nearly the same.
        let is_kin = what.contains(": uyvy ") || what.contains(": rgb565be ");
        !what.ends_with(" void") && !what.ends_with(" picture") && !is_kin
    };
    let rows: Vec<Row> = rows()?.into_iter().filter(shown).collect();
    let all = as_markdown(&rows);
    let chosen = rows
        .into_iter()
        .filter(|row| CHOSEN.contains(&row.what.as_str()));
    Ok(Figures {
        all,
        chosen: as_markdown(&chosen.collect::<Vec<_>>()),
    })
}
