//! What to ask for where no mesh meets the error: found by baking it.

use std::fmt;

use tectum_optics::{OutputMap, Rig};

use crate::bake::{BakeError, BakeOptions, MAX_ERROR_PX, bake_as_asked};

/// Pixels of the largest picture that is baked only to advise: it takes less than a second.
const MAX_TRIED_PX: usize = 2048 * 1024;
/// Errors that are tried: each is above what the one before came to.
const TRIED_ERRORS: usize = 3;

/// An option that gives a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sufficient {
    /// This error, px.
    MaxErrorPx(f64),
    /// This size of the same view, px.
    SizePx([u16; 2]),
}

impl fmt::Display for Sufficient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MaxErrorPx(error_px) => write!(f, "--max-error {error_px}"),
            Self::SizePx([width, height]) => write!(f, "--size {width}x{height}"),
        }
    }
}

/// An error or else a size that suffices for what cannot be baked, whose best mesh is off by
/// `best_px`. `None` for pictures of more than 2048x1024 px, and where nothing that was tried gives a table.
pub fn sufficient(rig: &Rig, options: &BakeOptions, best_px: f64) -> Option<Sufficient> {
    if best_px <= MAX_ERROR_PX {
        max_error_px(rig, options, best_px).map(Sufficient::MaxErrorPx)
    } else {
        size_px(rig, options).map(Sufficient::SizePx)
    }
}

fn max_error_px(rig: &Rig, options: &BakeOptions, best_px: f64) -> Option<f64> {
    let mut wanted_px = best_px;
    for _ in 0..TRIED_ERRORS {
        // Written with three decimals, and a little above: a larger margin at the border of the
        // source makes it another fit.
        let max_error_px = libm::ceil(wanted_px * 1.02 * 1e3) / 1e3;
        let more = BakeOptions {
            max_error_px,
            ..*options
        };
        if !is_small(&more.output) {
            return None;
        }
        match bake_as_asked(rig, &more) {
            Ok(_) => return Some(max_error_px),
            // The other eye's, or that of the other fit.
            Err(BakeError::Accuracy { best_px, .. }) => wanted_px = best_px.max(max_error_px),
            Err(_) => return None,
        }
    }
    None
}

fn size_px(rig: &Rig, options: &BakeOptions) -> Option<[u16; 2]> {
    let mut output = with_smaller_pixels(&options.output)?;
    while is_small(&output) {
        let larger = BakeOptions { output, ..*options };
        if bake_as_asked(rig, &larger).is_ok() {
            return Some(output.size_px);
        }
        output = with_smaller_pixels(&output)?;
    }
    None
}

fn is_small(output: &OutputMap) -> bool {
    let [width, height] = output.size_px.map(usize::from);
    width * height <= MAX_TRIED_PX
}

/// The same view in twice as many columns and rows; `None` if a table cannot be as large.
fn with_smaller_pixels(map: &OutputMap) -> Option<OutputMap> {
    let [width, height] = map.size_px.map(|side| side.checked_mul(2));
    let axis = |[first, step]: [f64; 2]| [first - step / 4.0, step / 2.0];
    Some(OutputMap {
        size_px: [width?, height?],
        u: axis(map.u),
        v: axis(map.v),
        ..*map
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake;
    use tectum_optics::Projection;

    /// What the message of an impossible table advises, and the options that follow it.
    fn advised(size_px: [u16; 2], max_error_px: f64) -> (Sufficient, String, Rig, BakeOptions) {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tables/rigs/paper-fish.toml"
        );
        let rig = Rig::load(path.as_ref()).unwrap();
        let mut options = BakeOptions {
            output: Projection::Equirect.output_map(size_px).unwrap(),
            max_error_px,
            feather_rad: 4f64.to_radians(),
        };
        let error = bake(&rig, &options).unwrap_err();
        let message = error.to_string();
        let BakeError::Accuracy {
            sufficient: Some(advice),
            ..
        } = error
        else {
            panic!("{message}");
        };
        match advice {
            Sufficient::MaxErrorPx(error_px) => options.max_error_px = error_px,
            Sufficient::SizePx(size_px) => {
                options.output = Projection::Equirect.output_map(size_px).unwrap();
            }
        }
        (advice, message, rig, options)
    }

    #[test]
    fn an_error_that_suffices_is_named() {
        let (advice, message, rig, options) = advised([320, 160], 0.01);
        let Sufficient::MaxErrorPx(error_px) = advice else {
            panic!("{message}");
        };
        assert!(
            message.contains(&format!("(--max-error {error_px} suffices)")),
            "{message}"
        );
        assert!(error_px > 0.01 && bake(&rig, &options).is_ok());
        let less = BakeOptions {
            max_error_px: 0.8 * error_px,
            ..options
        };
        assert!(bake(&rig, &less).is_err(), "{error_px} is far too much");
    }

    #[test]
    fn a_size_that_suffices_is_named_where_no_error_does() {
        let (advice, message, rig, options) = advised([16, 8], 0.05);
        let Sufficient::SizePx([width, height]) = advice else {
            panic!("{message}");
        };
        assert!(
            message.contains(&format!("(--size {width}x{height} suffices)")),
            "{message}"
        );
        assert!(bake(&rig, &options).is_ok());
    }
}
