//! Frames to pictures, in every format and sampler, blending included.

mod common;

use common::{Case, SMALL};
use criterion::{BenchmarkGroup, Throughput, measurement::WallTime};
use rayon::ThreadPool;
use tectum_bake::{Plane, bake, stitch_bands, with_plane};
use tectum_core::{Eye, Frame, PixelFormat, Sampler, Tables};

const LARGE: Case = Case {
    output_px: [2048, 1024],
    rig: "paper-fish-960",
    max_error_px: 0.05,
};

fn main() {
    let mut criterion = common::criterion();
    let pools = common::pools();
    for case in [SMALL, LARGE] {
        let (rig, options) = case.load();
        let bytes = bake(&rig, &options).expect("the shipped rig bakes").bytes;
        let tables = Tables::parse(&bytes).expect("a fresh table");
        let mut group = criterion.benchmark_group(format!("stitch {}", case.name()));
        let [width, height] = case.output_px.map(u64::from);
        group.throughput(Throughput::Elements(width * height));
        for (threads, pool) in &pools {
            for plane in Plane::ALL {
                with_plane!(plane, F => stitch::<F>(&mut group, &tables, threads, pool));
            }
        }
        group.finish();
    }
    criterion.final_summary();
}

fn stitch<F: PixelFormat + Sync>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    tables: &Tables<'_>,
    threads: &str,
    pool: &ThreadPool,
) {
    let [width, height] = tables.source_size_px(Eye::Left).expect("a left eye");
    let stride = usize::from(width) * F::BYTES_PER_PIXEL;
    // No kernel's time depends on what the picture shows.
    let data: Vec<u8> = (0..stride * usize::from(height).div_ceil(F::ROWS))
        .map(|i| (i * 31 % 251) as u8)
        .collect();
    let frame = Frame::<F>::new(&data, width, height, stride).expect("a frame");
    let [columns, rows] = [tables.output_width_px(), tables.output_height_px()].map(usize::from);
    let mut out = vec![0; columns * rows.div_ceil(F::ROWS) * F::BYTES_PER_PIXEL];
    for (name, sampler) in [
        ("nearest", Sampler::Nearest),
        ("bilinear", Sampler::Bilinear),
    ] {
        group.bench_function(format!("{} {name}, {threads}", F::NAME), |b| {
            b.iter(|| pool.install(|| stitch_bands(tables, sampler, &frame, &frame, &mut out)));
        });
    }
}
