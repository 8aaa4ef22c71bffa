//! The bytes of a table, field by field. All numbers are little-endian and unaligned, so a view
//! works at any address.

use zerocopy::little_endian::{I16, I32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// First four bytes of every table.
pub const MAGIC: [u8; 4] = *b"TCTM";
/// Major version this crate reads and writes.
pub const VERSION_MAJOR: u16 = 1;
/// Byte offset of the CRC-32 field, the only bytes that the CRC does not cover.
pub const CRC_OFFSET: usize = 12;

/// One of the two eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Eye {
    /// The eye on the left side of the body.
    Left,
    /// The eye on the right side of the body.
    Right,
}

impl Eye {
    /// Both eyes, left first.
    pub const BOTH: [Eye; 2] = [Eye::Left, Eye::Right];
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct Header {
    pub magic: [u8; 4],
    pub version_major: U16,
    pub version_minor: U16,
    pub file_length: U32,
    pub crc32: U32,
    pub output_width_px: U16,
    pub output_height_px: U16,
    pub section_count: U16,
    pub reserved: U16,
    pub rig_fingerprint: [u8; 8],
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct SectionEntry {
    pub tag: [u8; 4],
    pub offset: U32,
    pub length: U32,
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct MeshHeader {
    pub step_log2: u8,
    pub fraction_bits: u8,
    pub reserved: U16,
    pub first_cell_x: U16,
    pub first_cell_y: U16,
    pub cells_x: U16,
    pub cells_y: U16,
    pub origin_x_px: I16,
    pub origin_y_px: I16,
    pub source_width_px: U16,
    pub source_height_px: U16,
}

/// One mesh vertex: a source position relative to the mesh's origin, in pixels times
/// 2^[`fraction_bits`](crate::Mesh::fraction_bits).
#[derive(
    FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug, PartialEq, Eq,
)]
#[repr(C)]
pub struct Vertex {
    x: I16,
    y: I16,
}

impl Vertex {
    /// A vertex at `[x, y]`.
    pub const fn new(xy: [i16; 2]) -> Self {
        Self {
            x: I16::new(xy[0]),
            y: I16::new(xy[1]),
        }
    }

    /// `[x, y]`.
    #[inline(always)]
    pub const fn xy(&self) -> [i16; 2] {
        [self.x.get(), self.y.get()]
    }
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct OutputMapLayout {
    pub kind: u8,
    pub reserved: [u8; 3],
    pub rotation_q30: [I32; 9],
    pub u0_q28: I32,
    pub du_q28: I32,
    pub v0_q28: I32,
    pub dv_q28: I32,
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct EyeRaysHeader {
    pub centre_q16: [I32; 2],
    pub affine_q28: [I32; 4],
    pub rotation_q30: [I32; 9],
    pub position_q30: [I32; 3],
    pub radius_q16: U32,
    pub node_count: U16,
    pub flags: U16,
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct ToneHeader {
    pub present: U16,
    pub reserved: U16,
}

/// A pixel of the left and one of the right frame that see the same direction.
#[derive(
    FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug, PartialEq, Eq,
)]
#[repr(C)]
pub struct MeterPair {
    left: [U16; 2],
    right: [U16; 2],
}

impl MeterPair {
    /// A pair of pixels `[x, y]`.
    pub const fn new(left: [u16; 2], right: [u16; 2]) -> Self {
        let [[left_x, left_y], [right_x, right_y]] = [left, right];
        Self {
            left: [U16::new(left_x), U16::new(left_y)],
            right: [U16::new(right_x), U16::new(right_y)],
        }
    }

    /// The pixel `[x, y]` of an eye's frame.
    pub fn pixel(&self, eye: Eye) -> [u16; 2] {
        match eye {
            Eye::Left => self.left.map(U16::get),
            Eye::Right => self.right.map(U16::get),
        }
    }
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct OverlayHeader {
    pub line_px: u8,
    pub light: u8,
    pub dark: u8,
    pub glyph_width_px: u8,
    pub glyph_height_px: u8,
    pub glyphs: u8,
    pub lines: U16,
    pub placements: U16,
    pub reserved: U16,
}

#[derive(FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned, Clone, Copy, Debug)]
#[repr(C)]
pub struct OverlayBand {
    pub first_line: U16,
    pub lines: U16,
    pub first_placement: U16,
    pub placements: U16,
}

/// A straight piece of a line inside a band of the overlay. Positions are in 1/8 px, a pixel
/// reaching from its number to the next; rows count from the band's top.
#[derive(
    FromBytes,
    IntoBytes,
    KnownLayout,
    Immutable,
    Unaligned,
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
)]
#[repr(C)]
pub struct OverlayLine {
    x: [U16; 2],
    y: [u8; 2],
}

impl OverlayLine {
    /// A piece from `(x[0], y[0])` to `(x[1], y[1])`, 1/8 px; `y` rises.
    pub const fn new(x: [u16; 2], y: [u8; 2]) -> Self {
        Self {
            x: [U16::new(x[0]), U16::new(x[1])],
            y,
        }
    }

    /// Columns of both ends, 1/8 px.
    #[inline]
    pub fn x_units(&self) -> [i32; 2] {
        self.x.map(|x| i32::from(x.get()))
    }

    /// Rows of both ends below the band's top, 1/8 px; the first is not greater.
    #[inline]
    pub fn y_units(&self) -> [i32; 2] {
        self.y.map(i32::from)
    }
}

/// A glyph at a place of a band.
#[derive(
    FromBytes,
    IntoBytes,
    KnownLayout,
    Immutable,
    Unaligned,
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
)]
#[repr(C)]
pub struct Placement {
    pub(crate) x_px: U16,
    pub(crate) y_px: i8,
    pub(crate) glyph: u8,
}

impl Placement {
    /// Glyph number `glyph` with its left column at `x_px` and its top row `y_px` below the band's.
    pub const fn new(x_px: u16, y_px: i8, glyph: u8) -> Self {
        Self {
            x_px: U16::new(x_px),
            y_px,
            glyph,
        }
    }

    /// Left column, px.
    #[inline]
    pub fn x_px(&self) -> u16 {
        self.x_px.get()
    }

    /// Top row below the band's, px; negative in a band that the glyph reaches into from above.
    #[inline]
    pub fn y_px(&self) -> i32 {
        self.y_px.into()
    }

    /// Number of the glyph.
    #[inline]
    pub fn glyph(&self) -> u8 {
        self.glyph
    }
}
