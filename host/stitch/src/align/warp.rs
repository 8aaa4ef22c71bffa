//! The bend as a rig holds it.

use image::{ExtendedColorType, ImageEncoder, ImageError, codecs::png::PngEncoder};
use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_optics::convention::{angle_between, yaw_pitch};
use tectum_optics::{Projection, WarpMap};

use super::grid::Grid;
use super::lattice::Lattice;

/// Width and height of the raster, px: 0.7 degrees, some seven to a knot.
const SIZE_PX: [u16; 2] = [512, 256];
/// Step of its values, deg: 16 bits hold yaws of up to 32 degrees, which a bend of 6 degrees needs
/// at a pitch of 80.
const STEP_DEG: f64 = 0.001;
/// Value of no offset.
const NO_OFFSET: f64 = 32768.0;

/// Offsets of directions for both eyes, in whole steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    steps: Vec<[f64; 4]>,
    /// Greatest angle between a direction and the one that an eye shows in its place, deg.
    pub greatest_deg: f64,
}

impl Warp {
    /// Both eyes moved by half of the field, in opposite directions.
    pub(super) fn new(lattice: &Lattice, grid: &Grid) -> Option<Self> {
        Self::of(|shown| {
            let at = grid.position(shown);
            let apart = lattice.at(at);
            [0.5, -0.5].map(|sign| {
                // Exactly still where nothing moves: there the mesh needs nothing finer.
                if apart == [0.0; 2] {
                    return *shown;
                }
                grid.direction([at[0] + sign * apart[0], at[1] + sign * apart[1]])
            })
        })
    }

    /// The warp that shows in each unit direction, body frame, what lies in the `bent` directions for
    /// the left and the right eye.
    pub(crate) fn of(bent: impl Fn(&Vector3<f64>) -> [Vector3<f64>; 2] + Sync) -> Option<Self> {
        let map = Projection::Equirect.output_map(SIZE_PX).ok()?;
        let width = usize::from(SIZE_PX[0]);
        let pixel = |i: usize| {
            let shown = map.ray((i % width) as f64, (i / width) as f64)?;
            let (yaw, pitch) = yaw_pitch(&shown);
            let mut steps = [0.0; 4];
            let mut greatest = 0.0f64;
            for (eye, bent) in bent(&shown).into_iter().enumerate() {
                if bent == shown {
                    continue;
                }
                let (to_yaw, to_pitch) = yaw_pitch(&bent);
                let by_yaw = libm::remainder(to_yaw - yaw, std::f64::consts::TAU);
                for (k, by) in [by_yaw, to_pitch - pitch].into_iter().enumerate() {
                    let steps_of = libm::round(by.to_degrees() / STEP_DEG);
                    steps[2 * eye + k] = steps_of.clamp(-NO_OFFSET, NO_OFFSET - 1.0);
                }
                greatest = greatest.max(angle_between(&bent, &shown).to_degrees());
            }
            Some((steps, greatest))
        };
        let pixels = (0..width * usize::from(SIZE_PX[1])).into_par_iter();
        let found: Option<Vec<([f64; 4], f64)>> = pixels.map(pixel).collect();
        let found = found?;
        Some(Self {
            greatest_deg: found.iter().map(|(_, angle)| *angle).fold(0.0, f64::max),
            steps: found.into_iter().map(|(steps, _)| steps).collect(),
        })
    }

    /// Width and height of the raster, px, an equirect picture of the body.
    pub fn size_px(&self) -> [u16; 2] {
        SIZE_PX
    }

    /// Angle of one step of the values, deg: the rig's `warp_step_deg`.
    pub fn step_deg(&self) -> f64 {
        STEP_DEG
    }

    /// For a rig in memory.
    ///
    /// # Errors
    /// None for a warp that was made here.
    pub fn map(&self) -> Result<WarpMap, String> {
        WarpMap::new(SIZE_PX, STEP_DEG.to_radians(), self.steps.clone())
    }

    /// For a rig's folder: PNG, 16-bit RGBA.
    ///
    /// # Errors
    /// Of the encoder, which does not fail on pictures of this size.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        // The encoder takes 16-bit samples in the machine's own order.
        let samples = self
            .steps
            .iter()
            .flatten()
            .map(|step| (step + NO_OFFSET) as u16);
        let raw: Vec<u8> = samples.flat_map(u16::to_ne_bytes).collect();
        let [width, height] = SIZE_PX.map(u32::from);
        let mut png = Vec::new();
        PngEncoder::new(&mut png).write_image(&raw, width, height, ExtendedColorType::Rgba16)?;
        Ok(png)
    }
}
