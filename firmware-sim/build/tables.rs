//! Tables whose rows are of one kind throughout, so that each kernel can be counted alone.

use std::error::Error;

use tectum_tables::builder::{MeshData, OutputMapData, RunData, TableBuilder};
use tectum_tables::{Eye, ProjectionKind, Tables};

const STEP_LOG2: u8 = 4;
const STEP_PX: u16 = 1 << STEP_LOG2;
const FRACTION_BITS: u8 = 5;
/// Kept between the mesh and the border of the source, px.
const MARGIN_PX: f64 = 8.0;

/// Tables of the sizes of `like`, named by what their pixels are.
pub fn one_kind(like: &Tables) -> Result<[(&'static str, Vec<u8>); 3], Box<dyn Error>> {
    let width = like.output_width_px();
    let kinds = [
        ("one_eye", RunData::Left(width)),
        ("blend", RunData::Blend(width, [255, 0])),
        ("void", RunData::Void(width)),
    ];
    let [one_eye, blend, void] = kinds.map(|(name, run)| Ok((name, table(like, run)?)));
    one_eye.and_then(|one_eye| Ok([one_eye, blend?, void?]))
}

fn table(like: &Tables, run: RunData) -> Result<Vec<u8>, Box<dyn Error>> {
    let size = [like.output_width_px(), like.output_height_px()];
    let mesh = |eye| like.source_size_px(eye).map(|source| barrel(size, source));
    let builder = TableBuilder {
        output_size_px: size,
        rig_fingerprint: [0; 8],
        mesh: [mesh(Eye::Left), mesh(Eye::Right)],
        rows: vec![vec![run]; usize::from(size[1])],
        output_map: OutputMapData {
            kind: ProjectionKind::Equirect,
            rotation_q30: [1 << 30, 0, 0, 0, 1 << 30, 0, 0, 0, 1 << 30],
            u_q28: [0, 1 << 20],
            v_q28: [0, 1 << 20],
        },
        rays: [None, None],
        tone: Default::default(),
        meter_pairs: Vec::new(),
        overlay: None,
        metadata: String::new(),
    };
    let bytes = builder.to_bytes()?;
    Tables::parse(&bytes).map_err(|error| format!("a table of one kind: {error}"))?;
    Ok(bytes)
}

/// The whole output onto the whole source, with the bend of a fisheye: rows and columns away from
/// the middle are drawn in by up to a quarter.
fn barrel(output: [u16; 2], source: [u16; 2]) -> MeshData {
    let cells = output.map(|side| side.div_ceil(STEP_PX));
    let mut vertices = Vec::new();
    for row in 0..cells[1] + 3 {
        for column in 0..cells[0] + 3 {
            // -1..1 over the output.
            let [u, v] = [(column, output[0]), (row, output[1])].map(|(index, side)| {
                (f64::from(index) - 1.0) * f64::from(STEP_PX) / f64::from(side) * 2.0 - 1.0
            });
            let bent = [u * (1.0 - v * v / 4.0), v * (1.0 - u * u / 4.0)];
            let half = source.map(|side| f64::from(side) / 2.0 - MARGIN_PX);
            let scale = f64::from(1 << FRACTION_BITS);
            vertices.push([0, 1].map(|i| (bent[i] * half[i] * scale) as i16));
        }
    }
    MeshData {
        step_log2: STEP_LOG2,
        fraction_bits: FRACTION_BITS,
        first_cell: [0, 0],
        cells,
        origin_px: source.map(|side| (side / 2) as i16),
        source_size_px: source,
        vertices,
    }
}
