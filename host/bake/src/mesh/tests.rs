use super::*;

type Position = Option<[f64; 2]>;

/// Targets from a function of column and row. As many bytes of positions are kept as in a bake, or none.
fn targets<'a>(
    [width, height]: [usize; 2],
    kept: bool,
    position: impl Fn(usize, usize) -> Position + Sync + Clone + 'a,
) -> Targets<'a> {
    let again = position.clone();
    let mut targets = Targets::new(width, if kept { KEPT_BYTES } else { 0 }, move |y, spans| {
        let columns = spans.iter().cloned().flatten();
        columns.map(|x| again(x, y).unwrap()).collect()
    });
    for y in 0..height {
        targets.push_row((0..width).filter_map(|x| Some((x, position(x, y)?))));
    }
    targets
}

/// An equidistant 210 degree eye of `source` px a side looking straight left, in an equirect output.
fn fish_eye(
    width: usize,
    height: usize,
    source: f64,
) -> impl Fn(usize, usize) -> Position + Sync + Clone {
    let focal = (source / 2.0 - 2.0) / 105f64.to_radians();
    move |x, y| {
        let yaw = std::f64::consts::PI - (x as f64 + 0.5) / width as f64 * std::f64::consts::TAU;
        let pitch = ((y as f64 + 0.5) / height as f64 - 0.5) * std::f64::consts::PI;
        let ray = [
            pitch.cos() * yaw.cos(),
            pitch.cos() * yaw.sin(),
            -pitch.sin(),
        ];
        // Camera x = body x, y = -body z, z = body y.
        let [cx, cy, cz] = [ray[0], -ray[2], ray[1]];
        let theta = cx.hypot(cy).atan2(cz);
        let k = focal * theta / cx.hypot(cy).max(1e-12);
        let centre = (source - 1.0) / 2.0;
        (theta < 104f64.to_radians()).then_some([centre + k * cx, centre + k * cy])
    }
}

#[test]
fn a_mesh_of_step_16_meets_the_budget_of_the_small_table() {
    let targets = targets([640, 320], true, fish_eye(640, 320, 480.0));
    let mesh = fit(&targets, [480, 480], 4, 0.05).unwrap().unwrap();
    // Budgets of the design: 0.05 px worst, 0.01 px RMS, 4 KB.
    assert!(mesh.max_error_px <= 0.05, "{}", mesh.max_error_px);
    assert!(mesh.rms_error_px <= 0.01, "{}", mesh.rms_error_px);
    assert!(mesh.data.to_bytes().len() <= 4096);
}

/// In all rounds of polishing: no mesh of this step is as near as wanted.
#[test]
fn positions_that_are_traced_again_give_the_same_mesh() {
    let [kept, traced] = [true, false].map(|kept| {
        let targets = targets([640, 320], kept, fish_eye(640, 320, 480.0));
        let mesh = fit(&targets, [480, 480], 4, 0.024).unwrap().unwrap();
        assert!(mesh.max_error_px > 0.024, "{}", mesh.max_error_px);
        (mesh.data.to_bytes(), mesh.max_error_px, mesh.rms_error_px)
    });
    assert_eq!(kept, traced);
}

#[test]
fn nothing_shown_gives_no_mesh() {
    let targets = targets([3, 2], true, |_, _| None);
    assert!(fit(&targets, [10, 10], 4, 0.05).unwrap().is_none());
}

#[test]
fn a_mesh_is_exact_for_what_a_cubic_can_hold() {
    let targets = targets([40, 24], true, |x, y| {
        let (x, y) = (x as f64, y as f64);
        Some([10.0 + 0.5 * x + 0.25 * y, 5.0 + 0.75 * y])
    });
    let mesh = fit(&targets, [64, 64], 3, 0.0).unwrap().unwrap();
    // What is left is the rounding of vertices (Q8 here) and of positions: 1/512 px each, twice
    // at most 1.25 times for the vertices.
    assert!(mesh.max_error_px < 0.006, "{}", mesh.max_error_px);
}

/// What an eye shows around another eye's part of the picture is held by a mesh, however far apart
/// the vertices over that part would lie if they went on straight.
#[test]
fn vertices_over_what_the_other_eye_shows_hinder_no_coarse_mesh() {
    let all = fish_eye(2048, 1024, 1520.0);
    // The other eye looks straight right, and shows a little more than its half: both borders of the
    // hole lie at this eye's rim, 180 degrees apart in its picture.
    let is_others = |x: usize, y: usize| (980..2010).contains(&x) && (40..980).contains(&y);
    let targets = targets([2048, 1024], true, |x, y| {
        all(x, y).filter(|_| !is_others(x, y))
    });
    let mesh = fit(&targets, [1520, 1520], 5, 0.05).unwrap().unwrap();
    assert!(mesh.max_error_px <= 0.05, "{}", mesh.max_error_px);
}

#[test]
fn a_wide_picture_is_fitted_as_fast_as_a_high_one() {
    // The equations' band along the longer side would take minutes.
    let plane = |width: usize, height: usize| {
        targets([width, height], true, |x, y| {
            let (x, y) = (x as f64, y as f64);
            Some([10.0 + 0.05 * x + 0.02 * y, 5.0 + 0.03 * x + 0.05 * y])
        })
    };
    for [width, height] in [[6000, 16], [16, 6000]] {
        let mesh = fit(&plane(width, height), [512, 512], 3, 0.01);
        assert!(
            mesh.unwrap().unwrap().max_error_px < 0.01,
            "{width}x{height}"
        );
    }
}
