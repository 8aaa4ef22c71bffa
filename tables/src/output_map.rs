//! Which direction an output pixel looks in, and back.

use crate::error::{TableError, Tag};
use crate::layout::OutputMapLayout;

/// Formula from view-plane coordinates (u to the right, v down) to a direction in the view frame
/// (x forward, y left, z up).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProjectionKind {
    /// u = -yaw, v = pitch, both in rad.
    Equirect,
    /// u = -yaw in rad, v = tan(pitch).
    Cylindrical,
    /// (u, v) = angle off the x axis in rad times the unit vector (right, down).
    Fisheye,
    /// (u, v) = (-y/x, -z/x).
    Perspective,
}

impl ProjectionKind {
    /// All kinds, at the index that is their code in a table.
    pub const ALL: [ProjectionKind; 4] = [
        Self::Equirect,
        Self::Cylindrical,
        Self::Fisheye,
        Self::Perspective,
    ];

    /// The byte that stands for this kind.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// View of the section that ties output pixels to directions.
#[derive(Debug, Clone, Copy)]
pub struct OutputMap<'a> {
    kind: ProjectionKind,
    layout: &'a OutputMapLayout,
}

impl<'a> OutputMap<'a> {
    pub(crate) fn parse(layout: &'a OutputMapLayout) -> Result<Self, TableError> {
        let kind = ProjectionKind::ALL.get(usize::from(layout.kind)).copied();
        match kind {
            Some(kind)
                if layout.reserved == [0; 3]
                    && layout.du_q28.get() > 0
                    && layout.dv_q28.get() > 0 =>
            {
                Ok(Self { kind, layout })
            }
            _ => Err(TableError::Field {
                tag: Tag::OUTPUT_MAP,
            }),
        }
    }

    /// Formula.
    pub fn kind(&self) -> ProjectionKind {
        self.kind
    }

    /// Rotation body <- view, row by row, Q30.
    pub fn rotation_q30(&self) -> [i32; 9] {
        self.layout.rotation_q30.map(|v| v.get())
    }

    /// `[u0, du]` in Q28: u of pixel column x is `u0 + x du`.
    pub fn u_q28(&self) -> [i32; 2] {
        [self.layout.u0_q28.get(), self.layout.du_q28.get()]
    }

    /// `[v0, dv]` in Q28: v of pixel row y is `v0 + y dv`.
    pub fn v_q28(&self) -> [i32; 2] {
        [self.layout.v0_q28.get(), self.layout.dv_q28.get()]
    }
}
