//! Time of exact seams through an overlap of 400x1000 px: `cargo bench -p tectum-stitch`.

use criterion::{Criterion, criterion_group, criterion_main};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_stitch::seam::cut::{Lattice, Side, max_flow, shortest_cycle};

/// Smooth structures and noise, as the difference of two pictures has them, between the eyes' own
/// rows.
fn overlap([width, height]: [usize; 2], wraps: bool) -> Lattice {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut sides = vec![Side::Either; width * height];
    sides[..width].fill(Side::Left);
    sides[width * (height - 1)..].fill(Side::Right);
    let mut costs = || {
        let cost = |i: usize| {
            let (x, y) = ((i % width) as f64 * 0.0628, (i / width) as f64 * 0.043);
            let wave = 1.0 + libm::sin(x + libm::sin(1.7 * y)) * libm::cos(y + 0.3 * x);
            8 + (90.0 * wave) as u16 + rng.random_range(0..80)
        };
        (0..width * height).map(cost).collect()
    };
    let costs = [costs(), costs()];
    Lattice::new([width, height], wraps, sides, costs).expect("lists of one length")
}

fn seams(c: &mut Criterion) {
    for (name, size_px, wraps) in [
        ("along 1000 px", [1000, 400], false),
        ("along 400 px", [400, 1000], false),
        ("ring of 1000 px", [1000, 400], true),
        ("ring of 400 px", [400, 1000], true),
    ] {
        let lattice = overlap(size_px, wraps);
        c.bench_function(&format!("shortest cycle, {name}"), |b| {
            b.iter(|| shortest_cycle(&lattice));
        });
    }
    // What is cut where the eyes' own pixels are not one piece each: minutes at the size above.
    let lattice = overlap([200, 80], true);
    c.bench_function("greatest flow, ring of 200x80 px", |b| {
        b.iter(|| max_flow(&lattice))
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = seams
}
criterion_main!(benches);
