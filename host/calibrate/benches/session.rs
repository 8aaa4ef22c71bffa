//! A session of 30 real pictures of 1280x960 px, from pixels to a chosen lens, on two threads.
//!
//! `cargo bench -p tectum-calibrate` prints it; without the pictures it says so.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, SamplingMode};
use image::GrayImage;
use rayon::prelude::*;
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::solve::{Options, Problem, calibrate};
use tectum_calibrate::{Board, View};

const PICTURES: usize = 30;

fn pictures() -> Vec<GrayImage> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/camodocal-car-fisheye/images");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: no real pictures in {}", folder.display());
        return Vec::new();
    };
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| image::ImageFormat::from_path(file).is_ok());
    files.sort();
    let pictures = files.iter().take(PICTURES).map(image::open);
    pictures
        .map(|picture| picture.expect("a picture").to_luma8())
        .collect()
}

fn main() {
    let pictures = pictures();
    let Some(first) = pictures.first() else {
        return;
    };
    let size_px = first.dimensions().into();
    let board = Board {
        size: "9x6".parse().expect("a board"),
        square_mm: 120.0,
    };
    let session = || {
        let views: Vec<View> = pictures
            .par_iter()
            .map(|picture| detect(picture, board.size).expect("a board"))
            .collect();
        let problem = Problem {
            size_px,
            board,
            views,
        };
        calibrate(&problem, &Options::default())
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2);
    let pool = pool.build().expect("threads");
    // A run takes seconds: the fewest samples there are.
    let mut criterion = Criterion::default().sample_size(10).configure_from_args();
    let mut group = criterion.benchmark_group("calibrate");
    group.sampling_mode(SamplingMode::Flat);
    group.bench_function("30 pictures of 1280x960, 2 threads", |b| {
        b.iter(|| pool.install(|| black_box(session())));
    });
    group.finish();
    criterion.final_summary();
}
