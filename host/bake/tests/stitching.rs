//! A rig's own seam and warp, baked.

use tectum_bake::{BakeOptions, Pair, bake, verify};
use tectum_core::Tables;
use tectum_optics::{Projection, Rig, SeamMap, Stitching, WarpMap};
use tectum_tables::RunKind;

fn fish(side_px: u32) -> Rig {
    let centre = f64::from(side_px - 1) / 2.0;
    let focal = f64::from(side_px) * (238.0 / 480.0) / 105f64.to_radians();
    let eye = format!(
        "size_px = [{side_px}, {side_px}]\nfield_deg = 210.0\nlens = {{ model = 'equidistant', \
         focal_px_per_rad = {focal}, centre_px = [{centre}, {centre}] }}\n"
    );
    let text = format!(
        "name = 'paper-fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\n\
         psi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").expect("a sound rig")
}

#[test]
fn a_seam_and_a_warp_of_the_rig_are_baked() {
    let size_px = [640u16, 320];
    let at = |i: usize| ((i % 640) as f64, (i / 640) as f64);
    // A wavy cut ahead, and the rest as geometry has it; the left eye's picture is bent by up to
    // 0.3 degrees (half an output pixel) within 20 pixels of one place.
    let cut = |y: f64| 320.0 + 12.0 * (y / 20.0).sin();
    let shares = (0..640 * 320).map(at).map(|(x, y)| {
        let left = if (160.0..480.0).contains(&x) {
            x < cut(y)
        } else {
            x < 320.0
        };
        if left { 255 } else { 0 }
    });
    let bump = |x: f64, y: f64| {
        let square = ((x - 318.0).powi(2) + (y - 160.0).powi(2)) / 400.0;
        (-square).exp()
    };
    let steps = (0..640 * 320).map(at);
    let steps = steps.map(|(x, y)| [0.0, 300.0 * bump(x, y), 0.0, 0.0]);
    let mut rig = fish(480);
    rig.stitching = Some(Stitching {
        seam: Some(SeamMap::new(size_px, shares.collect()).unwrap()),
        warp: Some(WarpMap::new(size_px, 0.001f64.to_radians(), steps.collect()).unwrap()),
        tone: None,
    });
    let options = BakeOptions {
        output: Projection::Equirect.output_map(size_px).unwrap(),
        max_error_px: 0.05,
        feather_rad: 0.0,
    };
    let bent = bake(&rig, &options).unwrap();
    let tables = Tables::parse(&bent.bytes).unwrap();
    // The row in the middle: left up to the cut, right from there on.
    let mut runs = tables.runs(200);
    let border = runs.find(|run| run.start + run.len > 240 && run.kind != RunKind::Left);
    let border = f64::from(border.unwrap().start);
    assert!((border - cut(200.0)).abs() <= 1.0, "{border}");
    let frame: Vec<u8> = (0..480 * 480 * 3).map(|i| (i % 251) as u8).collect();
    let pair = Pair {
        left: &frame,
        right: &frame,
    };
    let same = verify(&tables, Some(&rig), pair).unwrap();
    assert_eq!(same.mismatches, 0);
    assert!(same.coordinate_error_px.unwrap().max <= 0.05);
    // 0.3 degrees of pitch are 0.68 source px on the axis, and as the place lies 79 degrees off it,
    // where they run round the axis, theta / sin theta times that: 0.95.
    let moved = verify(&tables, Some(&fish(480)), pair).unwrap();
    let moved = moved.coordinate_error_px.unwrap().max;
    assert!((0.85..1.0).contains(&moved), "{moved}");
}
