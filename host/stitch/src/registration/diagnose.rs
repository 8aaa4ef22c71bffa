//! What is wrong with pairs that fit no rotation, or a wrong one.

use super::consensus::Sample;
use super::tie::{Mount, Range, Rays, Tie};
use super::{Options, RegistrationError};
use crate::Eyes;
use crate::fault::Fault;

/// Share of the ties that must fit once the fault is undone.
const FITS: f64 = 0.5;

/// Undoes one fault after another; the one whose absence makes most ties fit, close to where the rig
/// has its eyes, is the error.
pub fn fault(
    mount: &Mount<'_>,
    ties: &[Tie],
    sample: &Sample<'_>,
    options: &Options,
) -> Option<RegistrationError> {
    let fault = Fault::find(|swapped, mirrored| {
        let repaired = ties
            .iter()
            .map(|tie| repaired(mount, tie, swapped, &mirrored));
        let with_rays = repaired.filter_map(|tie| Some((tie, mount.rays(&tie, [0.0; 2])?)));
        let (repaired, rays): (Vec<Tie>, Vec<Rays>) = with_rays.unzip();
        let sample = Sample {
            ties: &repaired,
            rays: &rays,
            ..*sample
        };
        !repaired.is_empty()
            && sample.consensus(options).is_ok_and(|consensus| {
                consensus.count() as f64 >= FITS * ties.len() as f64
                    && consensus.turn_rad(&sample.rotations) <= options.most_turn_rad
            })
    });
    Some(match fault? {
        Fault::Swapped => RegistrationError::Swapped,
        Fault::SwappedOrMirrored => RegistrationError::SwappedOrMirrored,
        Fault::Mirrored(eyes) => RegistrationError::Mirrored(eyes),
    })
}

fn repaired(mount: &Mount<'_>, tie: &Tie, swapped: bool, mirrored: &Eyes<bool>) -> Tie {
    let mut pixels = tie.pixels();
    for eye in 0..2 {
        if mirrored[eye] {
            pixels[eye][0] = f64::from(mount.eyes[eye].size_px[0]) - 1.0 - pixels[eye][0];
        }
    }
    let mut range = tie.range;
    if swapped {
        pixels.swap(0, 1);
        if let Range::Known(ranges_m) | Range::Board { ranges_m, .. } = &mut range {
            ranges_m.swap(0, 1);
        }
    }
    let mut pair = tie.pair;
    [pair.left_px, pair.right_px] = pixels;
    Tie { pair, range }
}
