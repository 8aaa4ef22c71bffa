//! From rig to table, and the proof of a table at start-up.

mod common;

use std::hint::black_box;

use common::{Case, SMALL};
use criterion::{SamplingMode, Throughput};
use tectum_bake::bake;
use tectum_core::Tables;
use tectum_tables::ProjectionKind;
use tectum_tables::builder::{MeshData, OutputMapData, RunData, TableBuilder};

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
    // What the bytes of a table can ask of the proof at most: every pixel a run of its own.
    let mut group = criterion.benchmark_group("parse");
    for (name, table) in [("runs of 32", runs_of(32)), ("runs of 1", runs_of(1))] {
        group.throughput(Throughput::Elements(u64::from(WIDTH) * u64::from(WIDTH)));
        group.bench_function(format!("{WIDTH}x{WIDTH}, {name} px"), |b| {
            b.iter(|| Tables::parse(black_box(&table)).map(|_| ()));
        });
    }
    group.finish();
    criterion.final_summary();
}

const WIDTH: u16 = 2048;

/// A table of runs of `len` pixels, which show one eye and both in turn.
fn runs_of(len: u16) -> Vec<u8> {
    let cells = [WIDTH / 32; 2];
    let mesh = MeshData {
        step_log2: 5,
        fraction_bits: 8,
        first_cell: [0; 2],
        cells,
        origin_px: [0; 2],
        source_size_px: [4; 2],
        vertices: vec![[100; 2]; cells.map(|n| usize::from(n) + 3).iter().product()],
    };
    let pair = [RunData::Left(len), RunData::Blend(len, [0, 255])];
    let table = TableBuilder {
        output_size_px: [WIDTH; 2],
        rig_fingerprint: [0; 8],
        mesh: [Some(mesh.clone()), Some(mesh)],
        rows: vec![pair.repeat(usize::from(WIDTH / len / 2)); usize::from(WIDTH)],
        output_map: OutputMapData {
            kind: ProjectionKind::Equirect,
            rotation_q30: [1 << 30, 0, 0, 0, 1 << 30, 0, 0, 0, 1 << 30],
            u_q28: [0, 1],
            v_q28: [0, 1],
        },
        rays: [None, None],
        tone: Default::default(),
        meter_pairs: Vec::new(),
        overlay: None,
        metadata: String::new(),
    };
    table.to_bytes().expect("equal rows are stored once")
}
