//! Why a byte string is not a table.

use crate::Eye;

/// Four ASCII letters that name a section. An upper-case first letter marks a section that a
/// reader must understand; a lower-case one may be skipped.
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tag(pub [u8; 4]);

impl Tag {
    /// Mesh of the left eye.
    pub const MESH_LEFT: Tag = Tag(*b"MSHL");
    /// Mesh of the right eye.
    pub const MESH_RIGHT: Tag = Tag(*b"MSHR");
    /// Runs of every output row.
    pub const RUNS: Tag = Tag(*b"RUNS");
    /// Output pixel to direction and back.
    pub const OUTPUT_MAP: Tag = Tag(*b"OMAP");
    /// Raw left-eye pixel to direction.
    pub const RAYS_LEFT: Tag = Tag(*b"rayl");
    /// Raw right-eye pixel to direction.
    pub const RAYS_RIGHT: Tag = Tag(*b"rayr");
    /// Tone curves.
    pub const TONE: Tag = Tag(*b"TONE");
    /// Pixels of both eyes that see the same.
    pub const METER_PAIRS: Tag = Tag(*b"pair");
    /// Lines and labels to draw over the output.
    pub const OVERLAY: Tag = Tag(*b"over");
    /// Free text about the table (UTF-8).
    pub const METADATA: Tag = Tag(*b"meta");

    /// Whether a reader that does not know this section must refuse the table.
    pub const fn is_critical(self) -> bool {
        self.0[0].is_ascii_uppercase()
    }

    pub(crate) const fn mesh(eye: Eye) -> Tag {
        match eye {
            Eye::Left => Tag::MESH_LEFT,
            Eye::Right => Tag::MESH_RIGHT,
        }
    }

    pub(crate) const fn rays(eye: Eye) -> Tag {
        match eye {
            Eye::Left => Tag::RAYS_LEFT,
            Eye::Right => Tag::RAYS_RIGHT,
        }
    }
}

impl core::fmt::Debug for Tag {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// Why [`crate::Tables::parse`] refused a byte string.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableError {
    /// Fewer bytes than a header, a directory or a section needs.
    TooShort,
    /// The file does not start with `TCTM`.
    Magic,
    /// A major version that this reader does not know.
    Version {
        /// Major version in the file.
        major: u16,
    },
    /// The length in the header is not the number of bytes given.
    Length {
        /// Length the header states, in bytes.
        stated: u32,
    },
    /// The CRC-32 does not match: the file is corrupt.
    Checksum,
    /// A field that must be zero is not, or the picture size is 0 or over the limit.
    Header,
    /// A section lies outside the file, is misaligned, out of order or of the wrong length.
    SectionBounds {
        /// Section at fault.
        tag: Tag,
    },
    /// The same section twice.
    Duplicate {
        /// Section at fault.
        tag: Tag,
    },
    /// A section that must be understood and is not known.
    Unknown {
        /// Section at fault.
        tag: Tag,
    },
    /// A section that every table needs, or a mesh that a run needs, is not there.
    Missing {
        /// Section at fault.
        tag: Tag,
    },
    /// A field of a section is out of its range.
    Field {
        /// Section at fault.
        tag: Tag,
    },
    /// Neighbouring mesh vertices lie further apart than the integer upsampling can hold.
    VertexJump {
        /// Eye of the mesh.
        eye: Eye,
    },
    /// The runs of a row are malformed, too many, or do not add up to the width.
    Runs {
        /// Output row.
        row: u16,
    },
    /// A pixel that a run shows would be read from outside the source frame or the mesh.
    SourceBox {
        /// Eye of the mesh.
        eye: Eye,
        /// Output row.
        row: u16,
    },
}

impl core::fmt::Display for TableError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooShort => write!(f, "the file is too short for a table: it may be truncated"),
            Self::Magic => write!(f, "not a table: it does not start with TCTM"),
            Self::Version { major } => {
                write!(
                    f,
                    "format version {major} is not known here: bake the table again"
                )
            }
            Self::Length { stated } => {
                write!(
                    f,
                    "the header states {stated} bytes, the file has another length"
                )
            }
            Self::Checksum => write!(f, "the checksum does not match: the file is corrupt"),
            Self::Header => write!(f, "the header holds a value out of range"),
            Self::SectionBounds { tag } => {
                write!(f, "section {tag:?} does not lie inside the file as it must")
            }
            Self::Duplicate { tag } => write!(f, "section {tag:?} is there twice"),
            Self::Unknown { tag } => {
                write!(
                    f,
                    "section {tag:?} must be understood and is not known to this version"
                )
            }
            Self::Missing { tag } => write!(f, "section {tag:?} is missing"),
            Self::Field { tag } => write!(f, "section {tag:?} holds a value out of range"),
            Self::VertexJump { eye } => {
                write!(f, "{eye:?} mesh: neighbouring vertices are too far apart")
            }
            Self::Runs { row } => {
                write!(
                    f,
                    "row {row}: the runs do not add up to the width, or are over 256"
                )
            }
            Self::SourceBox { eye, row } => {
                write!(
                    f,
                    "row {row}: a {eye:?} pixel lies outside the source frame or the mesh"
                )
            }
        }
    }
}

impl core::error::Error for TableError {}
