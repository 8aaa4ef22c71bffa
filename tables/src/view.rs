//! Checks a whole table once, then hands out views that need no checks.

use zerocopy::FromBytes;
use zerocopy::little_endian::U16;

use crate::error::{TableError, Tag};
use crate::eye_rays::EyeRays;
use crate::layout::{
    CRC_OFFSET, Eye, Header, MAGIC, MeterPair, OutputMapLayout, SectionEntry, VERSION_MAJOR,
};
use crate::mesh::Mesh;
use crate::output_map::OutputMap;
use crate::overlay::Overlay;
use crate::runs::{MAX_ROW_RUNS, Run, RunKind, Runs};
use crate::tone::{Channel, Curve, ToneCurves, meter_pairs};

/// Largest width and height of the output, px. It bounds the work of [`Tables::parse`].
pub const MAX_OUTPUT_PX: u16 = 8192;
/// Largest width and height of a source frame, px. Positions stay far inside an `i32` in Q8.
pub const MAX_SOURCE_PX: u16 = 16384;

/// CRC-32 of a table: every byte but the checksum itself.
pub(crate) fn checksum(bytes: &[u8]) -> Option<u32> {
    const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    digest.update(bytes.get(..CRC_OFFSET)?);
    digest.update(bytes.get(CRC_OFFSET + 4..)?);
    Some(digest.finalize())
}

/// A table that has been proven safe to run.
///
/// # Invariant
/// For every output pixel that a run shows, the bilinear source box (the pixel at the position
/// rounded down, its right, lower and lower right neighbours) lies inside a frame of
/// [`Mesh::source_size_px`]. The bytes are borrowed, so nothing can change them afterwards.
/// Kernels of `tectum-core` rely on this for memory safety.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    header: &'a Header,
    length: usize,
    mesh: [Option<Mesh<'a>>; 2],
    rays: [Option<EyeRays<'a>>; 2],
    runs: Runs<'a>,
    output_map: OutputMap<'a>,
    tone: ToneCurves<'a>,
    meter_pairs: &'a [MeterPair],
    /// Proven by [`Overlay::parse`]; empty if there is none.
    overlay: &'a [u8],
    metadata: &'a str,
}

impl<'a> Tables<'a> {
    /// Checks `bytes` and proves the invariant above. Takes about a dozen instructions for each
    /// output pixel and eye, no memory.
    ///
    /// # Errors
    /// Any [`TableError`]; never panics, whatever the bytes.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, TableError> {
        let (header, after_header) =
            Header::ref_from_prefix(bytes).map_err(|_| TableError::TooShort)?;
        check_header(header, bytes)?;
        let (entries, _) = <[SectionEntry]>::ref_from_prefix_with_elems(
            after_header,
            usize::from(header.section_count.get()),
        )
        .map_err(|_| TableError::TooShort)?;

        let sections = Sections::collect(bytes, entries)?;
        let missing = |tag| TableError::Missing { tag };
        let words = <[U16]>::ref_from_bytes(sections.runs.ok_or(missing(Tag::RUNS))?)
            .map_err(|_| TableError::SectionBounds { tag: Tag::RUNS })?;
        let map = sections.output_map.ok_or(missing(Tag::OUTPUT_MAP))?;
        let map = OutputMapLayout::ref_from_bytes(map).map_err(|_| TableError::SectionBounds {
            tag: Tag::OUTPUT_MAP,
        })?;
        let [mesh_left, mesh_right] = sections.mesh;
        let [rays_left, rays_right] = sections.rays;
        let mut tables = Self {
            header,
            length: bytes.len(),
            mesh: [
                mesh_left.map(|b| Mesh::parse(b, Eye::Left)).transpose()?,
                mesh_right.map(|b| Mesh::parse(b, Eye::Right)).transpose()?,
            ],
            rays: [
                rays_left
                    .map(|b| EyeRays::parse(b, Eye::Left))
                    .transpose()?,
                rays_right
                    .map(|b| EyeRays::parse(b, Eye::Right))
                    .transpose()?,
            ],
            runs: Runs::new(words, header.output_height_px.get())?,
            output_map: OutputMap::parse(map)?,
            tone: sections
                .tone
                .map_or(Ok(ToneCurves::default()), ToneCurves::parse)?,
            meter_pairs: &[],
            overlay: sections.overlay.unwrap_or(&[]),
            metadata: core::str::from_utf8(sections.metadata.unwrap_or(&[]))
                .map_err(|_| TableError::Field { tag: Tag::METADATA })?,
        };
        if let Some(pairs) = sections.meter_pairs {
            tables.meter_pairs = meter_pairs(pairs, &tables.mesh)?;
        }
        if sections.overlay.is_some() {
            Overlay::parse(tables.overlay, tables.output_size_px())?;
        }
        (0..tables.output_height_px()).try_for_each(|row| tables.prove_row(row))?;
        Ok(tables)
    }

    /// Proves that the runs of a row add up and that all source boxes lie inside their frames.
    fn prove_row(&self, row: u16) -> Result<(), TableError> {
        let mut columns = 0;
        for run in self.runs(row).take(MAX_ROW_RUNS) {
            columns += run.len;
            match run.kind {
                RunKind::Void => {}
                RunKind::Left => self.prove_run(Eye::Left, row, run)?,
                RunKind::Right => self.prove_run(Eye::Right, row, run)?,
                RunKind::Blend(_) => {
                    self.prove_run(Eye::Left, row, run)?;
                    self.prove_run(Eye::Right, row, run)?;
                }
            }
        }
        if columns == u32::from(self.output_width_px()) {
            Ok(())
        } else {
            Err(TableError::Runs { row })
        }
    }

    fn prove_run(&self, eye: Eye, row: u16, run: Run) -> Result<(), TableError> {
        let mesh = self.mesh(eye).ok_or(TableError::Missing {
            tag: Tag::mesh(eye),
        })?;
        // Rounded down, a position may be at most the last but one pixel: its box needs a neighbour.
        let [limit_x, limit_y] = mesh.source_size_px().map(|side| (u32::from(side) - 1) << 8);
        let mut columns = 0;
        let mut inside = true;
        for mut segment in mesh.segments(row, run.start, run.len) {
            columns += segment.len;
            for _ in 0..segment.len {
                // As unsigned numbers, negative positions are over any limit.
                inside &= (segment.x.position_q8() as u32) < limit_x
                    && (segment.y.position_q8() as u32) < limit_y;
                segment.step();
            }
        }
        if inside && columns == run.len {
            Ok(())
        } else {
            Err(TableError::SourceBox { eye, row })
        }
    }

    /// Width of the output, px.
    #[inline]
    pub fn output_width_px(&self) -> u16 {
        self.header.output_width_px.get()
    }

    /// Height of the output, px.
    #[inline]
    pub fn output_height_px(&self) -> u16 {
        self.header.output_height_px.get()
    }

    fn output_size_px(&self) -> [u16; 2] {
        [self.output_width_px(), self.output_height_px()]
    }

    /// Mesh of an eye, if the table shows that eye.
    #[inline]
    pub fn mesh(&self, eye: Eye) -> Option<&Mesh<'a>> {
        let [left, right] = &self.mesh;
        match eye {
            Eye::Left => left.as_ref(),
            Eye::Right => right.as_ref(),
        }
    }

    /// Width and height that frames of an eye must have, px.
    pub fn source_size_px(&self, eye: Eye) -> Option<[u16; 2]> {
        self.mesh(eye).map(Mesh::source_size_px)
    }

    /// Runs of one output row, left to right; they add up to the width.
    #[inline]
    pub fn runs(&self, row: u16) -> crate::RowRuns<'a> {
        self.runs.row(row, self.output_width_px())
    }

    /// Output pixel to direction and back.
    pub fn output_map(&self) -> &OutputMap<'a> {
        &self.output_map
    }

    /// Raw eye pixel to direction, if the table carries it.
    pub fn eye_rays(&self, eye: Eye) -> Option<&EyeRays<'a>> {
        let [left, right] = &self.rays;
        match eye {
            Eye::Left => left.as_ref(),
            Eye::Right => right.as_ref(),
        }
    }

    /// Tone curve of a channel of an eye; `None` if its values stay as they are.
    pub fn curve(&self, eye: Eye, channel: Channel) -> Option<&'a Curve> {
        self.tone.curve(eye, channel)
    }

    /// Pixels of both frames that see the same, for metering; inside the frames, at most 1024.
    pub fn meter_pairs(&self) -> &'a [MeterPair] {
        self.meter_pairs
    }

    /// Lines and labels to draw over the output, if the table carries them.
    pub fn overlay(&self) -> Option<Overlay<'a>> {
        Overlay::split(self.overlay, self.output_size_px())
    }

    /// Identity of the rig that made the table.
    pub fn rig_fingerprint(&self) -> [u8; 8] {
        self.header.rig_fingerprint
    }

    /// Free text about the table; empty if it has none.
    pub fn metadata(&self) -> &'a str {
        self.metadata
    }

    /// Length of the section of runs, bytes.
    pub fn runs_bytes(&self) -> usize {
        self.runs.length_bytes()
    }

    /// Length of the section of tone curves, bytes; 0 without one.
    pub fn tone_bytes(&self) -> usize {
        self.tone.length_bytes()
    }

    /// Length of the whole table, bytes.
    pub fn length_bytes(&self) -> usize {
        self.length
    }
}

fn check_header(header: &Header, bytes: &[u8]) -> Result<(), TableError> {
    if header.magic != MAGIC {
        return Err(TableError::Magic);
    }
    let major = header.version_major.get();
    if major != VERSION_MAJOR {
        return Err(TableError::Version { major });
    }
    let stated = header.file_length.get();
    if u32::try_from(bytes.len()) != Ok(stated) {
        return Err(TableError::Length { stated });
    }
    if checksum(bytes) != Some(header.crc32.get()) {
        return Err(TableError::Checksum);
    }
    let sizes = [header.output_width_px.get(), header.output_height_px.get()];
    if header.reserved.get() != 0 || sizes.iter().any(|px| !(1..=MAX_OUTPUT_PX).contains(px)) {
        return Err(TableError::Header);
    }
    Ok(())
}

/// Byte ranges of the known sections.
#[derive(Default)]
struct Sections<'a> {
    mesh: [Option<&'a [u8]>; 2],
    rays: [Option<&'a [u8]>; 2],
    runs: Option<&'a [u8]>,
    output_map: Option<&'a [u8]>,
    tone: Option<&'a [u8]>,
    meter_pairs: Option<&'a [u8]>,
    overlay: Option<&'a [u8]>,
    metadata: Option<&'a [u8]>,
}

impl<'a> Sections<'a> {
    fn collect(bytes: &'a [u8], entries: &[SectionEntry]) -> Result<Self, TableError> {
        let mut sections = Self::default();
        let mut end = size_of::<Header>() + size_of_val(entries);
        for entry in entries {
            let tag = Tag(entry.tag);
            let bounds = TableError::SectionBounds { tag };
            let (start, length) = (entry.offset.get() as usize, entry.length.get() as usize);
            if start < end || start % 4 != 0 {
                return Err(bounds);
            }
            end = start.checked_add(length).ok_or(bounds)?;
            let section = bytes.get(start..end).ok_or(bounds)?;
            let Self {
                mesh: [mesh_left, mesh_right],
                rays: [rays_left, rays_right],
                ..
            } = &mut sections;
            let slot = match tag {
                Tag::MESH_LEFT => mesh_left,
                Tag::MESH_RIGHT => mesh_right,
                Tag::RAYS_LEFT => rays_left,
                Tag::RAYS_RIGHT => rays_right,
                Tag::RUNS => &mut sections.runs,
                Tag::OUTPUT_MAP => &mut sections.output_map,
                Tag::TONE => &mut sections.tone,
                Tag::METER_PAIRS => &mut sections.meter_pairs,
                Tag::OVERLAY => &mut sections.overlay,
                Tag::METADATA => &mut sections.metadata,
                _ if tag.is_critical() => return Err(TableError::Unknown { tag }),
                _ => continue,
            };
            if slot.replace(section).is_some() {
                return Err(TableError::Duplicate { tag });
            }
        }
        Ok(sections)
    }
}
