//! Whatever the bytes: a typed error, or a table that is safe to run. Assertions in the core's
//! memory access are on here, so a position outside a frame that got past the parser fails.

use rand::RngExt;
use tectum_core::{Eye, TableError, Tables};
use tectum_exact::{cases, parse_and_run, rng, table};
use tectum_tables::builder::{MeshData, RunData, TableBuilder, seal, with_section};
use tectum_tables::{Mesh, Tag};

/// With one curve at most, for any byte of any curve is as good as another.
fn small_table(seed: u64) -> TableBuilder {
    let mut builder = table(&mut rng(seed), [20, 6]);
    let curves = builder.tone.iter_mut().flatten().filter(|c| c.is_some());
    curves.skip(1).for_each(|curve| *curve = None);
    builder
}

#[test]
fn every_flipped_byte_is_noticed() {
    let bytes = small_table(1).to_bytes().expect("few runs");
    for i in 0..bytes.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = bytes.clone();
            bytes[i] ^= flip;
            assert!(parse_and_run(&bytes).is_err(), "byte {i} ^ {flip:#x}");
        }
    }
}

#[test]
fn every_flipped_byte_behind_a_right_checksum_is_safe() {
    for seed in 0..cases(40) {
        let bytes = small_table(seed).to_bytes().expect("few runs");
        for i in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[i] ^= [0x01, 0x40, 0x80, 0xff][seed as usize % 4];
            seal(&mut bytes);
            let _ = parse_and_run(&bytes);
        }
    }
}

#[test]
fn random_damage_behind_a_right_checksum_is_safe() {
    for seed in 0..cases(20_000) {
        let mut rng = rng(seed);
        let mut bytes = table(&mut rng, [40, 6]).to_bytes().expect("few runs");
        for _ in 0..rng.random_range(1..6) {
            let i = rng.random_range(16..bytes.len());
            bytes[i] = rng.random();
        }
        seal(&mut bytes);
        let _ = parse_and_run(&bytes);
    }
}

#[test]
fn every_truncation_is_refused() {
    let mut builder = small_table(2);
    // A last section without padding, which may be cut.
    builder.metadata = "four".into();
    let bytes = builder.to_bytes().expect("few runs");
    for length in 0..bytes.len() {
        assert!(Tables::parse(&bytes[..length]).is_err(), "{length} bytes");
        let mut sealed = bytes[..length].to_vec();
        if let Some(field) = sealed.get_mut(8..12) {
            field.copy_from_slice(&(length as u32).to_le_bytes());
        }
        seal(&mut sealed);
        assert!(
            parse_and_run(&sealed).is_err(),
            "{length} bytes with a right length and checksum"
        );
    }
}

#[test]
fn a_position_over_any_edge_is_refused() {
    // A mesh that shows one constant position, in Q8 vertices of a 10x8 source.
    let constant = |position_q8: [i16; 2]| {
        let mut builder = small_table(3);
        let [w, h] = builder.output_size_px;
        builder.rows = vec![vec![RunData::Left(w)]; usize::from(h)];
        let cells = [w, h].map(|side| side.div_ceil(8));
        let count = cells.iter().map(|n| usize::from(*n) + 3).product();
        builder.mesh[0] = Some(MeshData {
            step_log2: 3,
            fraction_bits: 8,
            first_cell: [0, 0],
            cells,
            origin_px: [0, 0],
            source_size_px: [10, 8],
            vertices: vec![position_q8; count],
        });
        builder.to_bytes().expect("few runs")
    };
    let [right, bottom] = [9 * 256 - 1, 7 * 256 - 1];
    for inside in [[0, 0], [right, 0], [0, bottom], [right, bottom]] {
        assert_eq!(parse_and_run(&constant(inside)), Ok(()), "{inside:?}");
    }
    for outside in [[-1, 0], [0, -1], [right + 1, 0], [0, bottom + 1]] {
        let error = Tables::parse(&constant(outside)).unwrap_err();
        assert_eq!(
            error,
            TableError::SourceBox {
                eye: Eye::Left,
                row: 0
            },
            "{outside:?}"
        );
    }
}

/// The proof walks runs cell by cell; here each shown pixel is looked at by itself.
#[test]
fn a_table_is_accepted_where_every_shown_pixel_lies_inside_and_nowhere_else() {
    const WIDTH: u16 = 70;
    let mut verdicts = [0; 2];
    for seed in 0..cases(4000) {
        let mut rng = rng(seed);
        let mut builder = small_table(seed);
        builder.output_size_px = [WIDTH, 1];
        builder.overlay = None;
        builder.meter_pairs = Vec::new();
        let (mut row, mut column) = (Vec::new(), 0);
        while column < WIDTH {
            let most = [1, 3, 12, 40][seed as usize % 4].min(WIDTH - column);
            let len = rng.random_range(1..=most);
            row.push(match rng.random_range(0..4) {
                0 => RunData::Void(len),
                1 => RunData::Left(len),
                2 => RunData::Right(len),
                _ => RunData::Blend(len, [0, 255]),
            });
            column += len;
        }
        builder.mesh = Eye::BOTH.map(|_| {
            let step_log2 = rng.random_range(3..=5);
            let step = 1 << step_log2;
            // Some meshes begin or end inside the picture, some positions lie outside the frame.
            let first = u16::from(rng.random_bool(0.05));
            let cells = [
                WIDTH.div_ceil(step) - first - u16::from(rng.random_bool(0.05)),
                1,
            ];
            let count = usize::from(cells[0] + 3) * 4;
            let outside = rng.random_range(-1..=1);
            Some(MeshData {
                step_log2,
                fraction_bits: 8,
                first_cell: [first, 0],
                cells,
                origin_px: [0, 0],
                source_size_px: [3, 3],
                vertices: (0..count)
                    .map(|_| {
                        [0, 0].map(|_| rng.random_range(60 + 60 * -outside..450 + 60 * outside))
                    })
                    .collect(),
            })
        });
        let is_inside = |mesh: &Mesh<'_>, column: u32| {
            let segment = mesh.segments(0, column, 1).next();
            segment.is_some_and(|s| {
                let limits = 0..2 << 8;
                limits.contains(&s.x.position_q8()) && limits.contains(&s.y.position_q8())
            })
        };
        let sections = builder
            .mesh
            .clone()
            .map(|mesh| mesh.expect("two eyes").to_bytes());
        let [left, right] = [(&sections[0], Eye::Left), (&sections[1], Eye::Right)]
            .map(|(bytes, eye)| Mesh::parse(bytes, eye).expect("sound"));
        let mut column = 0;
        let mut sound = true;
        for run in &row {
            let (len, eyes) = match run {
                RunData::Void(len) => (*len, vec![]),
                RunData::Left(len) => (*len, vec![left]),
                RunData::Right(len) => (*len, vec![right]),
                RunData::Blend(len, _) => (*len, vec![left, right]),
            };
            for x in column..column + u32::from(len) {
                sound &= eyes.iter().all(|mesh| is_inside(mesh, x));
            }
            column += u32::from(len);
        }
        builder.rows = vec![row];
        let bytes = builder.to_bytes().expect("few runs");
        let verdict = Tables::parse(&bytes).map(|_| ());
        let refused = matches!(verdict, Err(TableError::SourceBox { row: 0, .. }));
        assert_eq!(
            (verdict.is_ok(), refused),
            (sound, !sound),
            "seed {seed}: {verdict:?}"
        );
        verdicts[usize::from(sound)] += 1;
    }
    // Both verdicts are common.
    assert!(
        verdicts.iter().all(|count| *count > cases(4000) / 10),
        "{verdicts:?}"
    );
}

#[test]
fn a_row_of_more_runs_than_the_format_allows_is_refused() {
    let with = |count: u16| {
        let mut builder = small_table(5);
        builder.output_size_px = [count, 1];
        builder.overlay = None;
        builder.rows = vec![vec![RunData::Void(1); usize::from(count)]];
        builder.to_bytes()
    };
    let bytes = with(256).expect("as many as a row may have");
    assert!(Tables::parse(&bytes).is_ok());
    assert!(with(257).is_err());
    // The same runs for a picture one pixel wider: what follows them in the file is not read.
    let mut bytes = bytes;
    bytes[16..18].copy_from_slice(&257u16.to_le_bytes());
    seal(&mut bytes);
    assert_eq!(
        Tables::parse(&bytes).unwrap_err(),
        TableError::Runs { row: 0 }
    );
}

#[test]
fn a_run_of_absurd_length_ends_with_the_mesh() {
    let mesh = small_table(4).mesh[0].clone().expect("two eyes");
    let bytes = mesh.to_bytes();
    let parsed = Mesh::parse(&bytes, Eye::Left).expect("sound");
    let step = parsed.step();
    let columns = u32::from(mesh.cells[0]) * step - 3;
    let pixels: u32 = parsed.segments(0, 3, u32::MAX).map(|s| s.len).sum();
    assert_eq!(pixels, columns);
    assert_eq!(parsed.segments(0, u32::MAX, u32::MAX).count(), 0);
}

#[test]
fn a_section_that_must_be_understood_is_and_others_are_skipped() {
    let mut builder = small_table(4);
    builder.tone = Default::default();
    builder.meter_pairs = Vec::new();
    builder.overlay = None;
    let bytes = builder.to_bytes().expect("few runs");
    let with = |tag: &[u8; 4], section: &[u8]| with_section(&bytes, Tag(*tag), section);
    let refused = |bytes: &[u8]| parse_and_run(bytes).unwrap_err();
    assert_eq!(parse_and_run(&with(b"else", &[1, 2, 3])), Ok(()));
    let unknown = Tag(*b"ELSE");
    assert_eq!(
        refused(&with(b"ELSE", &[])),
        TableError::Unknown { tag: unknown }
    );

    // Luma of the left eye: right, cut short at any byte, with more behind, with an unknown curve.
    let tone = [[1, 0, 0, 0].as_slice(), &[200; 256]].concat();
    let toned = with(b"TONE", &tone);
    assert_eq!(parse_and_run(&toned), Ok(()));
    let (tag, bounds) = (Tag::TONE, TableError::SectionBounds { tag: Tag::TONE });
    for length in 0..tone.len() {
        assert_eq!(refused(&with(b"TONE", &tone[..length])), bounds);
    }
    assert_eq!(
        refused(&with(b"TONE", &[tone.as_slice(), &[0]].concat())),
        bounds
    );
    assert_eq!(
        refused(&with(b"TONE", &[0, 64, 0, 0])),
        TableError::Field { tag }
    );
    let twice = with_section(&toned, tag, &tone);
    assert_eq!(refused(&twice), TableError::Duplicate { tag });

    let (tag, bounds) = (
        Tag::METER_PAIRS,
        TableError::SectionBounds {
            tag: Tag::METER_PAIRS,
        },
    );
    assert_eq!(parse_and_run(&with(b"pair", &[0; 16])), Ok(()));
    assert_eq!(refused(&with(b"pair", &[0; 15])), bounds);
    assert_eq!(
        refused(&with(b"pair", &[0, 0, 0, 0, 255, 0, 0, 0])),
        TableError::Field { tag }
    );
}

#[test]
fn the_fuzz_corpus_is_safe() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fuzz/corpus/tables");
    let mut files = 0;
    for entry in std::fs::read_dir(folder).expect("the corpus is part of the repository") {
        let bytes = std::fs::read(entry.expect("readable").path()).expect("readable");
        let _ = parse_and_run(&bytes);
        files += 1;
    }
    assert!(files >= 8, "{files} files: the corpus is not complete");
}
