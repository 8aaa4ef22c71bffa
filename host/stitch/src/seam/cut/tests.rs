use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

fn lattice(
    size_px: [usize; 2],
    wraps: bool,
    sides: Vec<Side>,
    mut cost: impl FnMut() -> u16,
) -> Lattice {
    let mut costs = || (0..sides.len()).map(|_| cost()).collect();
    let costs = [costs(), costs()];
    Lattice::new(size_px, wraps, sides, costs).unwrap()
}

/// An overlap as eyes have it: the left eye's own pixels above, the right's below, ragged, ending at
/// a void to both sides or running all round, with holes.
fn overlap(rng: &mut impl Rng, widest: usize) -> Lattice {
    let size_px = [rng.random_range(3..widest), rng.random_range(3..widest)];
    let [width, height] = size_px;
    let wraps = rng.random_bool(0.5);
    let mut sides = vec![Side::Either; width * height];
    let depth = 1.max(height / 3);
    for x in 0..width {
        let (above, below) = (rng.random_range(1..=depth), rng.random_range(1..=depth));
        for y in 0..above {
            sides[y * width + x] = Side::Left;
        }
        for y in height - below..height {
            sides[y * width + x] = Side::Right;
        }
    }
    let void_columns = if rng.random_bool(0.5) {
        rng.random_range(0..width)
    } else {
        0
    };
    for y in 1..height - 1 {
        for x in 0..void_columns {
            sides[y * width + x] = Side::Void;
        }
    }
    for _ in 0..rng.random_range(0..4) {
        let (x, y) = (rng.random_range(0..width), rng.random_range(1..height - 1));
        let owner = [Side::Void, Side::Void, Side::Left, Side::Right][rng.random_range(0..4)];
        for hole in [y * width + x, y * width + (x + 1) % width] {
            if sides[hole] == Side::Either {
                sides[hole] = owner;
            }
        }
    }
    // Few different costs make many equal cuts; many make one.
    let most = [1, 3, 200, MAX_COST][rng.random_range(0..4)];
    lattice(size_px, wraps, sides, || rng.random_range(0..=most))
}

/// Greatest flow by shortest augmenting ways (Edmonds and Karp 1972), on a matrix.
fn textbook(lattice: &Lattice) -> u64 {
    let count = lattice.sides.len();
    let (source, sink) = (count, count + 1);
    let mut room = vec![vec![0u64; count + 2]; count + 2];
    for i in 0..count {
        match lattice.sides[i] {
            Side::Left => room[source][i] = u64::from(u32::MAX),
            Side::Right => room[i][sink] = u64::from(u32::MAX),
            Side::Void => {}
            Side::Either => {
                let [to_left, to_right] = lattice.data.as_ref().map_or([0; 2], |d| d[i]);
                room[source][i] += u64::from(to_right);
                room[i][sink] += u64::from(to_left);
            }
        }
        for direction in 0..2 {
            let Some(other) = lattice.neighbour(i, direction) else {
                continue;
            };
            let cost = lattice.parting(i, other, direction).unwrap_or(0);
            room[i][other] += u64::from(cost);
            room[other][i] += u64::from(cost);
        }
    }
    let mut flow = 0;
    loop {
        let mut from = vec![usize::MAX; count + 2];
        let mut open = std::collections::VecDeque::from([source]);
        while let Some(node) = open.pop_front() {
            for next in 0..count + 2 {
                if from[next] == usize::MAX && next != source && room[node][next] > 0 {
                    from[next] = node;
                    open.push_back(next);
                }
            }
        }
        if from[sink] == usize::MAX {
            return flow;
        }
        let way: Vec<(usize, usize)> =
            std::iter::successors(Some((from[sink], sink)), |(node, _)| {
                (*node != source).then(|| (from[*node], *node))
            })
            .collect();
        let step = way.iter().map(|(a, b)| room[*a][*b]).min().unwrap();
        for (a, b) in way {
            room[a][b] -= step;
            room[b][a] += step;
        }
        flow += step;
    }
}

#[test]
fn shortest_cycle_and_greatest_flow_agree_on_a_thousand_overlaps() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut compared = 0;
    while compared < 1000 {
        // Small ones have every odd case; large ones cycles that wind.
        let widest = if compared % 20 == 0 { 150 } else { 24 };
        let lattice = overlap(&mut rng, widest);
        let flow = max_flow(&lattice);
        let Some(cycle) = shortest_cycle(&lattice) else {
            continue;
        };
        assert_eq!(cycle.cost, flow.cost, "{compared}: {lattice:?}");
        compared += 1;
    }
}

#[test]
fn greatest_flow_is_the_textbooks() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for case in 0..300 {
        let mut lattice = overlap(&mut rng, 9);
        // Any owners at all, and terms for single pixels.
        if case % 3 == 1 {
            let owners = [
                Side::Left,
                Side::Right,
                Side::Void,
                Side::Either,
                Side::Either,
            ];
            for side in &mut lattice.sides {
                *side = owners[rng.random_range(0..5)];
            }
        }
        if case % 3 == 2 {
            let data = (0..lattice.sides.len())
                .map(|_| [rng.random_range(0..40), rng.random_range(0..40)])
                .collect();
            lattice = lattice.with_data(data).unwrap();
            assert_eq!(shortest_cycle(&lattice), None);
        }
        assert_eq!(
            max_flow(&lattice).cost,
            textbook(&lattice),
            "{case}: {lattice:?}"
        );
        if let Some(cycle) = shortest_cycle(&lattice) {
            assert_eq!(cycle.cost, textbook(&lattice), "{case}: {lattice:?}");
        }
    }
}

#[test]
fn the_cut_follows_the_cheap_way_round_the_ring() {
    // A cheap wave in dear surroundings, on a ring of 60 columns.
    let wave =
        |x: usize| (10.0 + 6.0 * libm::sin(x as f64 / 60.0 * std::f64::consts::TAU)) as usize;
    let [width, height] = [60, 22];
    let mut sides = vec![Side::Either; width * height];
    sides[..width].fill(Side::Left);
    sides[width * (height - 1)..].fill(Side::Right);
    let below = |x, y| y <= wave(x);
    let cost = |same: bool| if same { 50 } else { 1 };
    let costs = |dx: usize, dy: usize| {
        (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                cost(below(x, y) == below((x + dx) % width, y + dy))
            })
            .collect::<Vec<u16>>()
    };
    let ring = Lattice::new([width, height], true, sides, [costs(1, 0), costs(0, 1)]).unwrap();
    let cut = shortest_cycle(&ring).unwrap();
    assert!((0..width * height).all(|i| cut.left[i] == below(i % width, i / width)));
    assert_eq!(cut, ring.cut());
    assert_eq!(cut.left, max_flow(&ring).left);
}

#[test]
fn an_overlap_in_two_pieces_and_one_with_a_board_are_cut_exactly() {
    // Front and back pieces with voids between them: still one way around the left eye.
    let [width, height] = [40, 20];
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut sides = vec![Side::Either; width * height];
    sides[..width].fill(Side::Left);
    sides[width * (height - 1)..].fill(Side::Right);
    for y in 0..height {
        for x in (8..12).chain(28..33) {
            sides[y * width + x] = match y {
                0..4 => Side::Left,
                16.. => Side::Right,
                _ => Side::Void,
            };
        }
    }
    let mut cost = || rng.random_range(1..100);
    let pieces = lattice([width, height], true, sides.clone(), &mut cost);
    let cycle = shortest_cycle(&pieces).expect("one piece for each eye");
    assert_eq!(cycle.cost, max_flow(&pieces).cost);
    // A board that the right eye must show whole, alone in the middle.
    for y in 7..11 {
        sides[y * width + 18..y * width + 24].fill(Side::Right);
    }
    let board = lattice([width, height], true, sides, &mut cost);
    assert_eq!(shortest_cycle(&board), None);
    let cut = board.cut();
    assert!(!cut.left[8 * width + 20]);
    assert_eq!(cut.cost, max_flow(&board).cost);
}

#[test]
fn nothing_to_decide_and_wrong_lengths() {
    let sides = vec![Side::Left, Side::Either, Side::Void, Side::Either];
    let one = lattice([2, 2], false, sides.clone(), || 5);
    assert_eq!(shortest_cycle(&one), None);
    assert_eq!(one.cut().cost, 0);
    assert_eq!(
        Lattice::new([2, 2], false, sides.clone(), [vec![0; 4], vec![0; 3]]),
        Err(LatticeError::Length("costs down", 3, 2, 2))
    );
    assert_eq!(
        Lattice::new([2, 2], false, sides, [vec![0; 4], vec![4096; 4]]),
        Err(LatticeError::Cost(4096))
    );
}
