//! Calibrates from corners in a file, in the format of a bench of other programs.
//!
//! usage: `calibrate_corners FILE [DEGREE]`
//!
//! FILE: `{"size": [w, h], "cols", "rows", "views": [[[x, y], ...], ...]}`, complete boards by rows
//! (x right, y down, 0-based centres). Prints
//! `{"a": [a0, a2, a3, ...], "cx", "cy", "c", "d", "e", "rms", "accepted"}` of the lens
//! `ray = (u, v, a0 + a2 r^2 + ...)`, `(x - cx, y - cy) = [[c, d], [e, 1]] (u, v)`.

use anyhow::Context;
use serde::Deserialize;
use serde_json::json;
use tectum_calibrate::solve::{Options, Problem, calibrate};
use tectum_calibrate::{Board, BoardSize, Corner, View};
use tectum_optics::CameraModel;

#[derive(Deserialize)]
struct Corners {
    size: [u32; 2],
    cols: u16,
    rows: u16,
    views: Vec<Vec<[f64; 2]>>,
}

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args_os().skip(1);
    let path = args
        .next()
        .context("usage: calibrate_corners FILE [DEGREE]")?;
    let degree = match args.next() {
        Some(degree) => Some(degree.to_string_lossy().parse().context("DEGREE")?),
        None => None,
    };
    let file: Corners = serde_json::from_slice(&std::fs::read(&path)?).context("corners")?;
    let labels = (0..file.rows).flat_map(|j| (0..file.cols).map(move |i| (i, j)));
    let view = |places: &Vec<[f64; 2]>| {
        let corners = labels.clone().zip(places).map(|((i, j), place)| Corner {
            i,
            j,
            position_px: *place,
            sigma_px: 0.1,
        });
        View {
            corners: corners.collect(),
        }
    };
    let problem = Problem {
        size_px: file.size,
        board: Board {
            size: BoardSize {
                columns: file.cols,
                rows: file.rows,
            },
            square_mm: 1.0,
        },
        views: file.views.iter().map(view).collect(),
    };
    let options = Options {
        degree,
        mirrored_labels: true,
        ..Options::default()
    };
    let result = calibrate(&problem, &options)?;
    let CameraModel::Ocam(lens) = &result.model else {
        anyhow::bail!("not a polynomial");
    };
    // Ours is x = x' + e y', y = d x' + c y'. With (u, v) = c (x', y') the last factor is 1; the
    // ray (x', y', f(rho)) is along (u, v, c f(r / c)).
    let [c, d, e] = lens.affine;
    let terms = lens.polynomial.iter().zip(0..).filter(|(_, k)| *k != 1);
    let terms: Vec<f64> = terms.map(|(a, k)| a * c.powi(1 - k)).collect();
    let line = json!({
        "a": terms,
        "cx": lens.centre_px[0],
        "cy": lens.centre_px[1],
        "c": 1.0 / c,
        "d": e / c,
        "e": d / c,
        "rms": result.rms_px,
        "accepted": result.views_used(),
        "corners": result.corners_used(),
        "held_out": result.held_out_rms_px,
        "parameters": result.parameters.len(),
    });
    println!("{line}");
    Ok(())
}
