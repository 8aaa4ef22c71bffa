//! Times Tectum on the raw inputs of a bench of other programs, so that all stand side by side.
//!
//! usage: `tectum-peers FOLDER [RUNS=15]`
//!
//! FOLDER holds `rig.json` (sizes), `stacked_bgr.u8` and `stacked_gray.u8` (left frame over right
//! frame) and `cv_fixed_hard_bgr.u8` (what OpenCV made of them, hard seam). Prints one line of
//! JSON for each case: nanoseconds per output pixel, bytes of table per output pixel, and for the
//! hard seam the mean absolute difference from OpenCV's picture.

mod rig;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use rayon::ThreadPool;
use serde_json::json;
use tectum_bake::{Baked, stitch_bands};
use tectum_core::{Frame, Gray8, PixelFormat, Rgb8, Sampler, Tables};

use rig::{Sizes, table};

/// Transition that blends a tenth of the output, as the peers do, degrees.
const FEATHER_DEG: f64 = 5.2;
const WARM_UP_RUNS: usize = 2;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args_os().skip(1);
    let folder = PathBuf::from(
        args.next()
            .context("usage: tectum-peers FOLDER [RUNS=15]")?,
    );
    let runs: usize = match args.next() {
        Some(runs) => runs.to_string_lossy().parse().context("RUNS")?,
        None => 15,
    };
    anyhow::ensure!(runs > 0, "RUNS must be at least 1");
    let sizes: Sizes = serde_json::from_slice(&read(&folder, "rig.json")?).context("rig.json")?;
    let [hard, blend] = [table(sizes, 0.0)?, table(sizes, FEATHER_DEG)?];
    let bgr = read(&folder, "stacked_bgr.u8")?;
    let gray = read(&folder, "stacked_gray.u8")?;
    let opencv = read(&folder, "cv_fixed_hard_bgr.u8")?;
    for threads in [1, 0] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let bench = Bench { sizes, runs, pool };
        let cases = [
            ("nearest_hard", &hard, Sampler::Nearest),
            ("bilinear_hard", &hard, Sampler::Bilinear),
            ("bilinear_blend", &blend, Sampler::Bilinear),
        ];
        bench.format::<Rgb8>("bgr", &bgr, cases, Some(&opencv))?;
        bench.format::<Gray8>("gray", &gray, cases, None)?;
    }
    Ok(())
}

fn read(folder: &Path, name: &str) -> anyhow::Result<Vec<u8>> {
    let path = folder.join(name);
    std::fs::read(&path).with_context(|| path.display().to_string())
}

struct Bench {
    sizes: Sizes,
    runs: usize,
    pool: ThreadPool,
}

impl Bench {
    /// Times the cases in turns, so that a busy machine is unkind to all of them, and prints them.
    fn format<F: PixelFormat + Sync>(
        &self,
        pix: &str,
        stacked: &[u8],
        cases: [(&str, &Baked, Sampler); 3],
        opencv: Option<&[u8]>,
    ) -> anyhow::Result<()> {
        let [width, height] = self.sizes.frame_px();
        let stride = usize::from(width) * F::BYTES_PER_PIXEL;
        let (left, right) = stacked
            .split_at_checked(stride * usize::from(height))
            .with_context(|| format!("the stacked {pix} frames are too short"))?;
        let [left, right] = [left, right].map(|data| Frame::<F>::new(data, width, height, stride));
        let (left, right) = (left?, right?);
        let bytes = self.sizes.output_pixels() * F::BYTES_PER_PIXEL;
        let mut outs = cases.map(|_| vec![0; bytes]);
        let mut seconds = cases.map(|_| Vec::with_capacity(self.runs));
        for run in 0..WARM_UP_RUNS + self.runs {
            for ((case, out), seconds) in cases.iter().zip(&mut outs).zip(&mut seconds) {
                let (_, baked, sampler) = *case;
                let tables = Tables::parse(&baked.bytes)?;
                let start = Instant::now();
                self.pool
                    .install(|| stitch_bands(&tables, sampler, &left, &right, out))?;
                if run >= WARM_UP_RUNS {
                    seconds.push(start.elapsed().as_secs_f64());
                }
            }
        }
        for (((name, baked, _), out), seconds) in cases.into_iter().zip(&outs).zip(&mut seconds) {
            let hard = baked.report.pixels.blend == 0;
            let difference = opencv.filter(|_| hard).map(|opencv| mean_abs(out, opencv));
            self.print(name, pix, baked, seconds, difference);
        }
        Ok(())
    }

    fn print(
        &self,
        case: &str,
        pix: &str,
        baked: &Baked,
        seconds: &mut [f64],
        difference: Option<f64>,
    ) {
        seconds.sort_by(f64::total_cmp);
        let pixels = self.sizes.output_pixels() as f64;
        let ns_px = |seconds: f64| round(seconds * 1e9 / pixels);
        let line = json!({
            "bench": "tectum",
            "case": case,
            "pix": pix,
            "threads": self.pool.current_num_threads(),
            "runs": seconds.len(),
            "ns_px_median": ns_px(seconds[seconds.len() / 2]),
            "ns_px_min": ns_px(seconds[0]),
            "ns_px_max": ns_px(seconds[seconds.len() - 1]),
            "table_bytes": baked.report.bytes.total,
            "table_bytes_px": round(baked.report.bytes.total as f64 / pixels),
            "coordinate_error_px_max": round(baked.report.coordinate_error_px.max),
            "blended_share": round(baked.report.pixels.blend as f64 / pixels),
            "mean_abs_diff_to_cv_fixed": difference.map(round),
        });
        println!("{line}");
    }
}

/// To four decimals, as the other programs print.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn mean_abs(a: &[u8], b: &[u8]) -> f64 {
    let sum: u64 = a
        .iter()
        .zip(b)
        .map(|(a, b)| u64::from(a.abs_diff(*b)))
        .sum();
    sum as f64 / a.len() as f64
}
