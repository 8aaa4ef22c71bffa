//! From rig to table, and the proof of a table at start-up.

mod common;

use std::hint::black_box;

use common::{Case, SMALL};
use criterion::{SamplingMode, Throughput};
use tectum_bake::bake;
use tectum_core::Tables;

const LARGE: Case = Case {
    output_px: [1280, 640],
    rig: "paper-fish-960",
    max_error_px: 0.035,
};

fn main() {
    let mut criterion = common::criterion();
    let pools = common::pools();
    for case in [SMALL, LARGE] {
        let (rig, options) = case.load();
        let mut group = criterion.benchmark_group("bake");
        group.sampling_mode(SamplingMode::Flat);
        for (threads, pool) in &pools {
            group.bench_function(format!("{}, {threads}", case.name()), |b| {
                b.iter(|| pool.install(|| bake(black_box(&rig), &options)));
            });
        }
        group.finish();

        let bytes = bake(&rig, &options).expect("the shipped rig bakes").bytes;
        let mut group = criterion.benchmark_group("parse");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(case.name(), |b| b.iter(|| Tables::parse(black_box(&bytes))));
        group.finish();
    }
    criterion.final_summary();
}
