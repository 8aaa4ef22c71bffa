//! Tone by definition.

use tectum_core::{Channel, Eye, Tables};

use super::position::round;
use crate::Format;

/// Channels of a format in the order of its planes.
fn channels(format: Format) -> &'static [Channel] {
    match format {
        Format::Gray8 => &[Channel::Luma],
        Format::Rgb8 | Format::Rgb565 | Format::Rgb565Be => {
            &[Channel::Red, Channel::Green, Channel::Blue]
        }
        Format::Yuyv | Format::Uyvy | Format::Nv12 => &[Channel::Luma, Channel::U, Channel::V],
    }
}

/// What the `value` of plane `plane` of an eye's frame becomes.
pub(super) fn toned(
    tables: &Tables<'_>,
    eye: Eye,
    format: Format,
    plane: usize,
    value: f64,
) -> f64 {
    let Some(curve) = tables.curve(eye, channels(format)[plane]) else {
        return value;
    };
    if format.unswapped() != Format::Rgb565 {
        return f64::from(curve[value as usize]);
    }
    // Binary fraction .vvvvv becomes .vvvvvvvv: the bits go on as they began.
    let full = if plane == 1 { 63.0 } else { 31.0 };
    let repeated = (value + value / (full + 1.0)) * 256.0 / (full + 1.0);
    round(f64::from(curve[repeated.floor() as usize]) * full / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::with_plane;
    use tectum_core::PixelFormat;

    #[test]
    fn planes_are_the_channels_of_the_core() {
        for format in Format::ALL {
            let planes = format.planes().iter();
            let core = planes.flat_map(|plane| with_plane!(plane, F => F::CHANNELS));
            let core: Vec<Channel> = core.copied().collect();
            assert_eq!(channels(format), core, "{format:?}");
        }
    }
}
