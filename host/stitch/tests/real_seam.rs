//! The seam of a real pair of 210 degree eyes, beside what other programs reach on it.

mod common;

use std::path::Path;

use common::{baked, stitched};
use tectum_optics::{Projection, Rig, Stitching};
use tectum_stitch::Views;
use tectum_stitch::seam::{Overlap, Quality, Seam, SeamOptions, band};

#[test]
fn the_seam_of_a_real_pair_is_hidden_better_than_peers_hide_it() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let Some(picture) = tectum_test_data::data("dual-fisheye-210/fishcam1.jpg") else {
        return;
    };
    let mut rig = Rig::load(&repository.join("tables/rigs/dual-fisheye-210.toml")).unwrap();
    let picture = image::open(picture).unwrap().into_rgb8();
    let size_px = [2048, 1024];
    let frame = band(&rig, size_px[0]).unwrap();
    let views = Views::render(&rig, [&picture, &picture], &frame);
    let overlap = Overlap::new(&views, 6.0);
    let seam = Seam::find(&[views], overlap, &SeamOptions::default()).unwrap();
    let shares = seam.shares.seam_map(size_px).unwrap();

    let output = Projection::Equirect.output_map(size_px).unwrap();
    let owns: Vec<bool> = (0..2048 * 1024)
        .map(|i| {
            output
                .ray(f64::from(i % 2048), f64::from(i / 2048))
                .unwrap()
        })
        .map(|ray| shares.left_share(&ray) >= 0.5)
        .collect();
    rig.stitching = Some(Stitching {
        seam: Some(shares),
        ..Stitching::default()
    });
    let baked = baked(&rig, &output, 0.0);
    let result = stitched(&baked, [&picture, &picture]);
    let shown = Views::render(&rig, [&picture, &picture], &output);
    let quality = Quality::measure(&shown, &result, &owns).unwrap();
    println!(
        "{quality:?}, runs of {} bytes, {:?}",
        baked.report.bytes.runs,
        seam.summary()
    );
    // The best of enblend, and of OpenCV's gain blocks with graph cut and multiband blending, each
    // by its strongest measure.
    assert!(quality.own_ssim >= 0.979, "{quality:?}");
    assert!(quality.ghost <= 0.12, "{quality:?}");
    assert!(quality.edge_excess <= -1.1, "{quality:?}");
}
