//! Which direction a pixel of the raw eye looks in.

use zerocopy::FromBytes;
use zerocopy::little_endian::{I32, U16};

use crate::error::{TableError, Tag};
use crate::layout::{Eye, EyeRaysHeader};

/// Fewest and most nodes of the angle curve.
const NODES: core::ops::RangeInclusive<u16> = 4..=257;

/// View of the section that ties raw pixels of one eye to directions in the body frame.
///
/// A pixel p goes through the affine map `A (p - centre)` to an offset of length rho from the
/// optical axis, less what decentring adds; its angle off the axis is a curve over rho, given at equally spaced nodes from 0
/// to [`EyeRays::radius_q16`]; the ray is then turned into the body frame.
#[derive(Debug, Clone, Copy)]
pub struct EyeRays<'a> {
    header: &'a EyeRaysHeader,
    angles: &'a [U16],
    decentring: Option<&'a [I32; 2]>,
}

/// Flag of a decentred lens.
const DECENTRED: u16 = 1;

impl<'a> EyeRays<'a> {
    pub(crate) fn parse(bytes: &'a [u8], eye: Eye) -> Result<Self, TableError> {
        let tag = Tag::rays(eye);
        let (header, rest) =
            EyeRaysHeader::ref_from_prefix(bytes).map_err(|_| TableError::SectionBounds { tag })?;
        let (angles, rest) =
            <[U16]>::ref_from_prefix_with_elems(rest, usize::from(header.node_count.get()))
                .map_err(|_| TableError::SectionBounds { tag })?;
        let decentring = match header.flags.get() {
            DECENTRED => {
                let both = <[I32; 2]>::ref_from_prefix(rest);
                Some(both.map_err(|_| TableError::SectionBounds { tag })?.0)
            }
            _ => None,
        };
        let sound = NODES.contains(&header.node_count.get())
            && header.flags.get() <= DECENTRED
            && header.radius_q16.get() > 0;
        if sound {
            Ok(Self {
                header,
                angles,
                decentring,
            })
        } else {
            Err(TableError::Field { tag })
        }
    }

    /// Principal point (distortion centre) `[x, y]`, px in Q16.
    pub fn centre_q16(&self) -> [i32; 2] {
        self.header.centre_q16.map(|v| v.get())
    }

    /// The matrix A, row by row, Q28.
    pub fn affine_q28(&self) -> [i32; 4] {
        self.header.affine_q28.map(|v| v.get())
    }

    /// Rotation body <- camera, row by row, Q30.
    pub fn rotation_q30(&self) -> [i32; 9] {
        self.header.rotation_q30.map(|v| v.get())
    }

    /// Position of the eye in the body frame over the stitch distance, Q30; 0 for infinity.
    pub fn position_q30(&self) -> [i32; 3] {
        self.header.position_q30.map(|v| v.get())
    }

    /// Offset from the centre at the last node, px in Q16.
    pub fn radius_q16(&self) -> u32 {
        self.header.radius_q16.get()
    }

    /// Angle off the axis at node `i`, rad in Q14; the curve is odd about 0 and goes on straight
    /// beyond its last node.
    pub fn angle_q14(&self, i: i32) -> i32 {
        let last = self.angles.len() as i32 - 1;
        let node = |i: i32| {
            self.angles
                .get(i as usize)
                .map_or(0, |a| i32::from(a.get()))
        };
        if i < 0 {
            -node(-i)
        } else if i > last {
            2 * node(last) - node(2 * last - i)
        } else {
            node(i)
        }
    }

    /// Decentring `[t1, t2]` of the lens, 1/px in Q44; `None` for one on its axis.
    pub fn decentring_q44(&self) -> Option<[i32; 2]> {
        self.decentring.map(|both| both.map(|v| v.get()))
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u16 {
        self.header.node_count.get()
    }
}
