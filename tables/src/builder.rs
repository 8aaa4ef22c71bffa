//! Writes tables. For the host: needs an allocator.

mod overlay;

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use zerocopy::little_endian::{I16, I32, U16, U32};
use zerocopy::{FromBytes, IntoBytes};

use crate::error::Tag;
use crate::layout::{
    CRC_OFFSET, EyeRaysHeader, Header, MAGIC, MeshHeader, MeterPair, OutputMapLayout, SectionEntry,
    ToneHeader, VERSION_MAJOR, Vertex,
};
use crate::runs::MAX_ROW_RUNS;
use crate::view::checksum;
use crate::{Channel, Curve, Eye, ProjectionKind};

pub use overlay::{BandData, OverlayData, OverlayTooLong};

/// Minor version of a table without any section that came later.
const VERSION_MINOR: u16 = 0;
/// Minor version that brought tone curves and metering pairs.
const VERSION_MINOR_TONE: u16 = 1;
/// Minor version that brought the overlay.
const VERSION_MINOR_OVERLAY: u16 = 2;

/// The minor version that a table with this section has at least.
fn minor_of(tag: Tag) -> u16 {
    match tag {
        Tag::TONE | Tag::METER_PAIRS => VERSION_MINOR_TONE,
        Tag::OVERLAY => VERSION_MINOR_OVERLAY,
        _ => VERSION_MINOR,
    }
}

/// The mesh of one eye, owned. Fields as in [`crate::Mesh`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshData {
    /// Step = 2^this: 3, 4 or 5.
    pub step_log2: u8,
    /// Bits after the binary point of the vertices: 4..=8.
    pub fraction_bits: u8,
    /// First cell: column, row.
    pub first_cell: [u16; 2],
    /// Number of cells: columns, rows.
    pub cells: [u16; 2],
    /// Source position that vertices are relative to, px.
    pub origin_px: [i16; 2],
    /// Width and height of the source frame, px.
    pub source_size_px: [u16; 2],
    /// `(cells[0] + 3) x (cells[1] + 3)` vertices, row by row: x, y.
    pub vertices: Vec<[i16; 2]>,
}

impl MeshData {
    /// The bytes of the mesh's section.
    pub fn to_bytes(&self) -> Vec<u8> {
        let header = MeshHeader {
            step_log2: self.step_log2,
            fraction_bits: self.fraction_bits,
            reserved: U16::new(0),
            first_cell_x: U16::new(self.first_cell[0]),
            first_cell_y: U16::new(self.first_cell[1]),
            cells_x: U16::new(self.cells[0]),
            cells_y: U16::new(self.cells[1]),
            origin_x_px: I16::new(self.origin_px[0]),
            origin_y_px: I16::new(self.origin_px[1]),
            source_width_px: U16::new(self.source_size_px[0]),
            source_height_px: U16::new(self.source_size_px[1]),
        };
        let mut bytes = header.as_bytes().to_vec();
        for vertex in &self.vertices {
            bytes.extend_from_slice(Vertex::new(*vertex).as_bytes());
        }
        bytes
    }
}

/// One run of an output row, owned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RunData {
    /// Background.
    Void(u16),
    /// Left eye alone.
    Left(u16),
    /// Right eye alone.
    Right(u16),
    /// Both eyes: number of pixels, left weight at the start edge and at the end edge (0..=255
    /// stand for 0..=1).
    Blend(u16, [u8; 2]),
}

impl RunData {
    /// Longest run that one record holds; [`TableBuilder`] splits longer ones.
    const MAX_LENGTH: u16 = 0x3fff;

    fn words(self) -> impl Iterator<Item = u16> {
        let (kind, length, ramp) = match self {
            Self::Void(n) => (0, n, None),
            Self::Left(n) => (1, n, None),
            Self::Right(n) => (2, n, None),
            Self::Blend(n, edges) => (3, n, Some(u16::from_le_bytes(edges))),
        };
        // The output is at most 8192 px wide, so every run that fits it fits a record.
        [kind << 14 | length.min(Self::MAX_LENGTH)]
            .into_iter()
            .chain(ramp)
    }
}

/// Fields as in [`crate::OutputMap`], owned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputMapData {
    /// Formula.
    pub kind: ProjectionKind,
    /// Rotation body <- view, row by row, Q30.
    pub rotation_q30: [i32; 9],
    /// `[u0, du]`, Q28.
    pub u_q28: [i32; 2],
    /// `[v0, dv]`, Q28.
    pub v_q28: [i32; 2],
}

/// Fields as in [`crate::EyeRays`], owned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EyeRaysData {
    /// Principal point `[x, y]`, px in Q16.
    pub centre_q16: [i32; 2],
    /// Affine map from pixel offset to ideal offset, row by row, Q28.
    pub affine_q28: [i32; 4],
    /// Rotation body <- camera, row by row, Q30.
    pub rotation_q30: [i32; 9],
    /// Eye position over stitch distance, Q30.
    pub position_q30: [i32; 3],
    /// Offset at the last node, px in Q16.
    pub radius_q16: u32,
    /// Angle off the axis at equally spaced nodes from 0, rad in Q14.
    pub angles_q14: Vec<u16>,
    /// Decentring `[t1, t2]`, 1/px in Q44.
    pub decentring_q44: Option<[i32; 2]>,
}

/// Curves of one eye, at the index of their [`Channel`]; `None` keeps values as they are.
pub type ToneData = [Option<Curve>; Channel::ALL.len()];

/// A table to be written. Build it up, then call [`TableBuilder::to_bytes`].
///
/// What is written is not checked here: [`crate::Tables::parse`] is the one place that decides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableBuilder {
    /// Width and height of the output, px.
    pub output_size_px: [u16; 2],
    /// Identity of the rig.
    pub rig_fingerprint: [u8; 8],
    /// Meshes: left, right.
    pub mesh: [Option<MeshData>; 2],
    /// Runs of every row.
    pub rows: Vec<Vec<RunData>>,
    /// Output pixel to direction.
    pub output_map: OutputMapData,
    /// Raw eye pixel to direction: left, right.
    pub rays: [Option<EyeRaysData>; 2],
    /// Tone curves: left, right. No section is written if there is none.
    pub tone: [ToneData; 2],
    /// Pixels of both frames that see the same. No section is written if there is none.
    pub meter_pairs: Vec<MeterPair>,
    /// Bytes of the overlay's section, as [`OverlayData::to_bytes`] gives them.
    pub overlay: Option<Vec<u8>>,
    /// Free text; nothing is written if empty.
    pub metadata: String,
}

/// More runs than a table can hold: [`MAX_ROW_RUNS`] in a row, 128 KB of distinct rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunsTooLong {
    /// First row that has too many, or whose runs the 16-bit row index cannot reach.
    pub row: usize,
}

impl core::fmt::Display for RunsTooLong {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "row {}: more runs than a table holds, which are {MAX_ROW_RUNS} in a row and 128 KB of \
             different rows",
            self.row
        )
    }
}

impl core::error::Error for RunsTooLong {}

impl TableBuilder {
    /// The table as bytes. The same input gives the same bytes.
    ///
    /// # Errors
    /// [`RunsTooLong`] if the rows differ too much to be indexed.
    pub fn to_bytes(&self) -> Result<Vec<u8>, RunsTooLong> {
        let mut sections: Vec<(Tag, Vec<u8>)> = Vec::new();
        for (eye, mesh) in Eye::BOTH.into_iter().zip(&self.mesh) {
            sections.extend(mesh.as_ref().map(|m| (Tag::mesh(eye), m.to_bytes())));
        }
        sections.push((Tag::RUNS, runs_bytes(&self.rows)?));
        sections.push((Tag::OUTPUT_MAP, output_map_bytes(&self.output_map)));
        for (eye, rays) in Eye::BOTH.into_iter().zip(&self.rays) {
            sections.extend(rays.as_ref().map(|r| (Tag::rays(eye), rays_bytes(r))));
        }
        sections.extend(tone_bytes(&self.tone).map(|bytes| (Tag::TONE, bytes)));
        if !self.meter_pairs.is_empty() {
            sections.push((Tag::METER_PAIRS, self.meter_pairs.as_bytes().to_vec()));
        }
        sections.extend(self.overlay.clone().map(|bytes| (Tag::OVERLAY, bytes)));
        if !self.metadata.is_empty() {
            sections.push((Tag::METADATA, self.metadata.as_bytes().to_vec()));
        }
        Ok(self.assemble(&sections))
    }

    fn assemble(&self, sections: &[(Tag, Vec<u8>)]) -> Vec<u8> {
        let minors = sections.iter().map(|(tag, _)| minor_of(*tag));
        let version_minor = minors.max().unwrap_or(VERSION_MINOR);
        let header_length = size_of::<Header>() + sections.len() * size_of::<SectionEntry>();
        let mut directory = Vec::new();
        let mut body = Vec::new();
        for (tag, bytes) in sections {
            let entry = SectionEntry {
                tag: tag.0,
                offset: U32::new((header_length + body.len()) as u32),
                length: U32::new(bytes.len() as u32),
            };
            directory.extend_from_slice(entry.as_bytes());
            body.extend_from_slice(bytes);
            body.resize(body.len().next_multiple_of(4), 0);
        }
        let header = Header {
            magic: MAGIC,
            version_major: U16::new(VERSION_MAJOR),
            version_minor: U16::new(version_minor),
            file_length: U32::new((header_length + body.len()) as u32),
            crc32: U32::new(0),
            output_width_px: U16::new(self.output_size_px[0]),
            output_height_px: U16::new(self.output_size_px[1]),
            section_count: U16::new(sections.len() as u16),
            reserved: U16::new(0),
            rig_fingerprint: self.rig_fingerprint,
        };
        let mut bytes = header.as_bytes().to_vec();
        bytes.append(&mut directory);
        bytes.append(&mut body);
        seal(&mut bytes);
        bytes
    }
}

/// `table` with one more section behind the others, sealed; it may have any tag and bytes.
/// The minor version becomes the section's, if that is greater. Does nothing to a string too short for its own
/// directory.
pub fn with_section(table: &[u8], tag: Tag, section: &[u8]) -> Vec<u8> {
    const ENTRY: usize = size_of::<SectionEntry>();
    let parts = Header::read_from_prefix(table)
        .ok()
        .and_then(|(header, rest)| {
            let directory = ENTRY * usize::from(header.section_count.get());
            Some((header, rest.split_at_checked(directory)?))
        });
    let Some((mut header, (directory, body))) = parts else {
        return table.to_vec();
    };
    let mut entries = Vec::new();
    for entry in directory.as_chunks::<ENTRY>().0 {
        let mut entry: SectionEntry = zerocopy::transmute!(*entry);
        entry.offset += ENTRY as u32;
        entries.push(entry);
    }
    let mut body = body.to_vec();
    body.resize(body.len().next_multiple_of(4), 0);
    entries.push(SectionEntry {
        tag: tag.0,
        offset: U32::new((size_of::<Header>() + directory.len() + ENTRY + body.len()) as u32),
        length: U32::new(section.len() as u32),
    });
    body.extend_from_slice(section);
    let length = size_of::<Header>() + ENTRY * entries.len() + body.len();
    header.file_length = U32::new(length as u32);
    header.section_count = U16::new(entries.len() as u16);
    header.version_minor = U16::new(header.version_minor.get().max(minor_of(tag)));
    let mut bytes = [header.as_bytes(), entries.as_bytes(), &body].concat();
    seal(&mut bytes);
    bytes
}

/// Writes the right checksum into `bytes`, so that tests and fuzzers reach what lies behind it.
/// Does nothing to a string too short for a header.
pub fn seal(bytes: &mut [u8]) {
    let crc = checksum(bytes);
    if let (Some(crc), Some(field)) = (crc, bytes.get_mut(CRC_OFFSET..CRC_OFFSET + 4)) {
        field.copy_from_slice(&crc.to_le_bytes());
    }
}

fn runs_bytes(rows: &[Vec<RunData>]) -> Result<Vec<u8>, RunsTooLong> {
    let mut seen: BTreeMap<&[RunData], u16> = BTreeMap::new();
    let mut index = Vec::with_capacity(rows.len());
    let mut pool: Vec<u16> = Vec::new();
    for (row, runs) in rows.iter().enumerate() {
        if runs.len() > MAX_ROW_RUNS {
            return Err(RunsTooLong { row });
        }
        let start = match seen.get(runs.as_slice()) {
            Some(start) => *start,
            None => {
                let start = u16::try_from(pool.len()).map_err(|_| RunsTooLong { row })?;
                pool.extend(runs.iter().flat_map(|run| run.words()));
                seen.insert(runs, start);
                start
            }
        };
        index.push(start);
    }
    index.append(&mut pool);
    Ok(index.iter().flat_map(|word| word.to_le_bytes()).collect())
}

fn output_map_bytes(map: &OutputMapData) -> Vec<u8> {
    OutputMapLayout {
        kind: map.kind.code(),
        reserved: [0; 3],
        rotation_q30: map.rotation_q30.map(I32::new),
        u0_q28: I32::new(map.u_q28[0]),
        du_q28: I32::new(map.u_q28[1]),
        v0_q28: I32::new(map.v_q28[0]),
        dv_q28: I32::new(map.v_q28[1]),
    }
    .as_bytes()
    .to_vec()
}

fn rays_bytes(rays: &EyeRaysData) -> Vec<u8> {
    let header = EyeRaysHeader {
        centre_q16: rays.centre_q16.map(I32::new),
        affine_q28: rays.affine_q28.map(I32::new),
        rotation_q30: rays.rotation_q30.map(I32::new),
        position_q30: rays.position_q30.map(I32::new),
        radius_q16: U32::new(rays.radius_q16),
        node_count: U16::new(rays.angles_q14.len() as u16),
        flags: U16::new(u16::from(rays.decentring_q44.is_some())),
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(rays.angles_q14.iter().flat_map(|a| a.to_le_bytes()));
    let decentring = rays.decentring_q44.iter().flatten();
    bytes.extend(decentring.flat_map(|t| t.to_le_bytes()));
    bytes
}

fn tone_bytes(tone: &[ToneData; 2]) -> Option<Vec<u8>> {
    let mut present = 0;
    let mut curves = Vec::new();
    for (eye, tone) in Eye::BOTH.into_iter().zip(tone) {
        for (channel, curve) in Channel::ALL.into_iter().zip(tone) {
            if let Some(curve) = curve {
                present |= channel.bit(eye);
                curves.extend_from_slice(curve);
            }
        }
    }
    let header = ToneHeader {
        present: U16::new(present),
        reserved: U16::new(0),
    };
    (present != 0).then(|| [header.as_bytes(), &curves].concat())
}
