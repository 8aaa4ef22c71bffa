//! Time of a registration from twelve rendered pairs of 960x960 px, step by step as
//! `tectum register` takes them: `cargo bench -p tectum-stitch --bench register`. Wall time of one
//! run on all cores; decoding of files and the page of the report are not in it.

#[path = "../tests/common/board_pool.rs"]
mod board_pool;

use std::time::Instant;

use board_pool::{eyes, rig, scene, taken, target};
use image::{DynamicImage, RgbImage};
use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_calibrate::target::Target;
use tectum_optics::rotation_vector;
use tectum_stitch::align::{AlignOptions, align};
use tectum_stitch::colour::match_eyes;
use tectum_stitch::distance::{Toward, scene_distance};
use tectum_stitch::matching::{Sighting, match_boards};
use tectum_stitch::registration::{Options, Tie, register};
use tectum_stitch::seam::band;
use tectum_stitch::{Eyes, Views};

const PAIRS: usize = 12;

fn main() {
    let (rig, target) = (rig(), target());
    let axes = eyes(&rig).map(|eye| eye.pose.optical_axis());
    let middle = (axes[0] + axes[1]).normalize();
    let shots: Vec<Eyes<RgbImage>> = (0..PAIRS)
        .into_par_iter()
        .map(|k| {
            // Around the middle of the overlap.
            let angle = k as f64 * 2.4;
            let off = Vector3::new(0.0, libm::cos(angle), libm::sin(angle)) * 0.25;
            let at = rotation_vector(&off) * middle * (0.3 + 0.02 * k as f64);
            let scene = scene(&target, at, 30.0 * k as f64);
            [0, 1].map(|eye: usize| {
                let seed = (2 * k + eye) as u32;
                taken(&scene, eyes(&rig)[eye], at, f64::INFINITY, seed)
            })
        })
        .collect();
    let threads = rayon::current_num_threads();
    println!("{PAIRS} pairs of 960x960 px on {threads} threads");
    let all = Instant::now();
    let mut clock = all;
    let mut step = |what: String| {
        println!("{:7.2} s  {what}", clock.elapsed().as_secs_f64());
        clock = Instant::now();
    };

    let targets = [Target::Overlap(target)];
    let sightings: Vec<Eyes<Sighting>> = shots
        .par_iter()
        .map(|shot| {
            shot.each_ref().map(|picture| {
                let gray = DynamicImage::from(picture.clone()).to_luma8();
                Sighting::find(&gray, &targets).expect("a known dictionary")
            })
        })
        .collect();
    let lenses = eyes(&rig).map(|eye| &eye.eye);
    let ties = Tie::of_boards(&match_boards(lenses, &targets, &sightings, None));
    step(format!("boards found and paired: {} corners", ties.len()));

    let found = register(&rig, &ties, &Options::default()).expect("boards all around");
    step(format!("eyes registered: {:.3} px RMS", found.rms_px));

    let pairs: Vec<Eyes<&RgbImage>> = shots.iter().map(|shot| shot.each_ref()).collect();
    let distance = scene_distance(&found.rig, &pairs[..3], Toward::Everywhere).expect("an overlap");
    step(format!(
        "stitch distance sought: {:?} m",
        distance.map(|found| found.distance_m)
    ));

    let frame = band(&found.rig, 1024).expect("an overlap");
    let views: Vec<Views> = pairs
        .iter()
        .map(|pair| Views::render(&found.rig, *pair, &frame))
        .collect();
    let colour = match_eyes(&found.rig, &views).expect("an overlap");
    step("colours matched".to_owned());

    let options = AlignOptions::default();
    let aligned = align(&found.rig, &pairs, Some(&colour.curves), &options).expect("a seam");
    step(format!(
        "seam cut and aligned: SSIM {:.3}, {:.3} after",
        aligned.summary.ssim_before, aligned.summary.ssim_after
    ));
    println!("{:7.2} s  in all", all.elapsed().as_secs_f64());
}
