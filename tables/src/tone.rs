//! What each eye's values become, and where both eyes look at the same thing.

use zerocopy::FromBytes;

use crate::error::{TableError, Tag};
use crate::layout::{Eye, MeterPair, ToneHeader};
use crate::mesh::Mesh;

/// What each 8-bit value of a channel becomes.
pub type Curve = [u8; 256];

/// A channel that may have a curve; its code is its bit in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// Luma: Gray8, Yuyv, Uyvy, Nv12.
    Luma,
    /// Blue difference: Yuyv, Uyvy, Nv12.
    U,
    /// Red difference: Yuyv, Uyvy, Nv12.
    V,
    /// Red: Rgb8, Rgb565, Rgb565Be.
    Red,
    /// Green: Rgb8, Rgb565, Rgb565Be.
    Green,
    /// Blue: Rgb8, Rgb565, Rgb565Be.
    Blue,
}

impl Channel {
    /// All channels, each at the index that is its bit.
    pub const ALL: [Channel; 6] = [
        Self::Luma,
        Self::U,
        Self::V,
        Self::Red,
        Self::Green,
        Self::Blue,
    ];

    /// The bit that says a curve of `eye` for this channel is there.
    pub(crate) const fn bit(self, eye: Eye) -> u16 {
        1 << (self as u16 + 8 * eye as u16)
    }
}

/// All bits of [`Channel::bit`].
const KNOWN: u16 = 0x3f3f;
/// Most metering pairs of a table.
const MAX_PAIRS: usize = 1024;

/// The curves of a table. A channel without one keeps its values.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ToneCurves<'a> {
    present: u16,
    curves: &'a [Curve],
}

impl<'a> ToneCurves<'a> {
    pub(crate) fn parse(bytes: &'a [u8]) -> Result<Self, TableError> {
        let bounds = TableError::SectionBounds { tag: Tag::TONE };
        let (header, rest) = ToneHeader::ref_from_prefix(bytes).map_err(|_| bounds)?;
        let present = header.present.get();
        if present & !KNOWN != 0 || header.reserved.get() != 0 {
            return Err(TableError::Field { tag: Tag::TONE });
        }
        let curves = <[Curve]>::ref_from_bytes(rest).map_err(|_| bounds)?;
        if curves.len() != present.count_ones() as usize {
            return Err(bounds);
        }
        Ok(Self { present, curves })
    }

    pub(crate) fn curve(&self, eye: Eye, channel: Channel) -> Option<&'a Curve> {
        let bit = channel.bit(eye);
        let before = (self.present & (bit - 1)).count_ones() as usize;
        self.curves.get(before).filter(|_| self.present & bit != 0)
    }

    pub(crate) fn length_bytes(&self) -> usize {
        let header = if self.present == 0 {
            0
        } else {
            size_of::<ToneHeader>()
        };
        header + size_of_val(self.curves)
    }
}

/// The metering pairs of a table with these meshes, left and right.
pub(crate) fn meter_pairs<'a>(
    bytes: &'a [u8],
    [left, right]: &[Option<Mesh<'_>>; 2],
) -> Result<&'a [MeterPair], TableError> {
    let tag = Tag::METER_PAIRS;
    let pairs =
        <[MeterPair]>::ref_from_bytes(bytes).map_err(|_| TableError::SectionBounds { tag })?;
    let (Some(left), Some(right)) = (left, right) else {
        return Err(TableError::Field { tag });
    };
    let inside = |mesh: &Mesh<'_>, eye: Eye, pair: &MeterPair| {
        let ([x, y], [width, height]) = (pair.pixel(eye), mesh.source_size_px());
        x < width && y < height
    };
    let sound = |pair| inside(left, Eye::Left, pair) && inside(right, Eye::Right, pair);
    if pairs.len() <= MAX_PAIRS && pairs.iter().all(sound) {
        Ok(pairs)
    } else {
        Err(TableError::Field { tag })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::MeshData;

    fn section(present: u16, curves: usize) -> Vec<u8> {
        let mut bytes = present.to_le_bytes().to_vec();
        bytes.extend([0, 0]);
        for curve in 0..curves {
            bytes.extend([curve as u8; 256]);
        }
        bytes
    }

    #[test]
    fn curves_are_found_by_rank() {
        let present = Channel::V.bit(Eye::Left)
            | Channel::Luma.bit(Eye::Right)
            | Channel::Blue.bit(Eye::Right);
        let bytes = section(present, 3);
        let tone = ToneCurves::parse(&bytes).unwrap();
        let first = |eye, channel| tone.curve(eye, channel).map(|curve| curve[0]);
        assert_eq!(first(Eye::Left, Channel::V), Some(0));
        assert_eq!(first(Eye::Right, Channel::Luma), Some(1));
        assert_eq!(first(Eye::Right, Channel::Blue), Some(2));
        assert_eq!(first(Eye::Left, Channel::Luma), None);
        assert_eq!(first(Eye::Right, Channel::V), None);
        assert_eq!(tone.length_bytes(), 772);
    }

    #[test]
    fn malformed_tone_is_refused() {
        let tag = Tag::TONE;
        let refused = |bytes: &[u8]| ToneCurves::parse(bytes).unwrap_err();
        let bounds = TableError::SectionBounds { tag };
        assert_eq!(refused(&[]), bounds);
        assert_eq!(refused(&section(1, 0)), bounds);
        assert_eq!(refused(&section(1, 2)), bounds);
        assert_eq!(refused(&section(3, 2)[..515]), bounds);
        assert_eq!(refused(&section(1 << 6, 1)), TableError::Field { tag });
        let mut reserved = section(1, 1);
        reserved[3] = 1;
        assert_eq!(refused(&reserved), TableError::Field { tag });
    }

    #[test]
    fn pairs_outside_a_frame_are_refused() {
        let tag = Tag::METER_PAIRS;
        let section = |size| {
            let mesh = MeshData {
                step_log2: 3,
                fraction_bits: 8,
                first_cell: [0; 2],
                cells: [1; 2],
                origin_px: [0; 2],
                source_size_px: size,
                vertices: vec![[0; 2]; 16],
            };
            mesh.to_bytes()
        };
        let [left, right] = [section([10, 8]), section([6, 4])];
        let meshes = [
            Some(Mesh::parse(&left, Eye::Left).unwrap()),
            Some(Mesh::parse(&right, Eye::Right).unwrap()),
        ];
        let bytes = |numbers: [u16; 4]| numbers.map(u16::to_le_bytes).concat();
        let inside = bytes([9, 7, 5, 3]);
        assert_eq!(meter_pairs(&inside, &meshes).unwrap().len(), 1);
        for outside in [[10, 0, 0, 0], [0, 8, 0, 0], [0, 0, 6, 0], [0, 0, 0, 4]] {
            let error = meter_pairs(&bytes(outside), &meshes).unwrap_err();
            assert_eq!(error, TableError::Field { tag }, "{outside:?}");
        }
        let one_eye = meter_pairs(&inside, &[meshes[0], None]).unwrap_err();
        assert_eq!(one_eye, TableError::Field { tag });
        let cut = meter_pairs(&inside[..7], &meshes).unwrap_err();
        assert_eq!(cut, TableError::SectionBounds { tag });
        let many = meter_pairs(&vec![0; 8 * (MAX_PAIRS + 1)], &meshes).unwrap_err();
        assert_eq!(many, TableError::Field { tag });
    }
}
