//! Pictures of more than 8 bits: cameras of 10, 12 and 14 bits leave them in files of 16, the low bits
//! used. What is there becomes 8 bits, whatever the file could hold.

use image::DynamicImage;

/// Bits that cameras have.
const CAMERA_BITS: [u32; 4] = [8, 10, 12, 14];

/// Bits of a picture's samples: of a file of 16 bits the fewest of 8, 10, 12 and 14 that hold its
/// largest value, opacity aside, as the file does not say; 8 of all others.
pub(crate) fn bits_used(picture: &DynamicImage) -> u32 {
    let Some(samples) = samples(picture) else {
        return 8;
    };
    let is_colour = is_colour(picture);
    let colours = samples.iter().enumerate().filter(|(i, _)| is_colour(*i));
    let largest = colours.map(|(_, sample)| *sample).max().unwrap_or(0);
    let holds = |bits: &u32| u32::from(largest) < 1 << bits;
    CAMERA_BITS.into_iter().find(holds).unwrap_or(16)
}

/// The picture in 8 bits, its samples being of `bits`.
pub(crate) fn to_8_bits(mut picture: DynamicImage, bits: u32) -> DynamicImage {
    if (8..16).contains(&bits) {
        let white = (1u32 << bits) - 1;
        let is_colour = is_colour(&picture);
        if let Some(samples) = samples_mut(&mut picture) {
            let colours = samples.iter_mut().enumerate();
            for (_, sample) in colours.filter(|(i, _)| is_colour(*i)) {
                let full = (u32::from(*sample) * 65535 + white / 2) / white;
                *sample = u16::try_from(full).unwrap_or(u16::MAX);
            }
        }
    }
    match picture {
        DynamicImage::ImageLuma16(_) => picture.into_luma8().into(),
        DynamicImage::ImageLumaA16(_) => picture.into_luma_alpha8().into(),
        DynamicImage::ImageRgb16(_) => picture.into_rgb8().into(),
        DynamicImage::ImageRgba16(_) => picture.into_rgba8().into(),
        other => other,
    }
}

/// Whether a sample, by its place, is a colour's and not the opacity's.
fn is_colour(picture: &DynamicImage) -> impl Fn(usize) -> bool + use<> {
    let channels = usize::from(picture.color().channel_count());
    let colours = channels - usize::from(picture.color().has_alpha());
    move |i| i % channels < colours
}

fn samples(picture: &DynamicImage) -> Option<&[u16]> {
    match picture {
        DynamicImage::ImageLuma16(p) => Some(p.as_raw()),
        DynamicImage::ImageLumaA16(p) => Some(p.as_raw()),
        DynamicImage::ImageRgb16(p) => Some(p.as_raw()),
        DynamicImage::ImageRgba16(p) => Some(p.as_raw()),
        _ => None,
    }
}

fn samples_mut(picture: &mut DynamicImage) -> Option<&mut [u16]> {
    match picture {
        DynamicImage::ImageLuma16(p) => Some(&mut *p),
        DynamicImage::ImageLumaA16(p) => Some(&mut *p),
        DynamicImage::ImageRgb16(p) => Some(&mut *p),
        DynamicImage::ImageRgba16(p) => Some(&mut *p),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma};

    /// A ramp of all values of `bits`.
    fn ramp(bits: u32, shift: u32) -> DynamicImage {
        let value = |x: u32| Luma([u16::try_from(x << shift).unwrap()]);
        ImageBuffer::from_fn(1 << bits, 1, |x, _| value(x)).into()
    }

    #[test]
    fn what_is_there_becomes_eight_bits() {
        for bits in [8, 10, 12, 14, 16] {
            let picture = ramp(bits, 0);
            assert_eq!(bits_used(&picture), bits);
            let gray = to_8_bits(picture, bits).into_luma8();
            assert_eq!((gray[(0, 0)].0, gray[((1 << bits) - 1, 0)].0), ([0], [255]));
            for x in 0..1u32 << bits {
                let exact = 255.0 * f64::from(x) / f64::from((1u32 << bits) - 1);
                // Half a step, and what rounding twice adds.
                let off = f64::from(gray[(x, 0)].0[0]) - exact;
                assert!(off.abs() <= 0.51, "{bits} {x}: {off}");
            }
        }
    }

    #[test]
    fn opacity_is_no_brightness() {
        let picture = ImageBuffer::from_pixel(2, 2, image::LumaA([1023u16, 65535])).into();
        assert_eq!(bits_used(&picture), 10);
        let gray = to_8_bits(picture, 10);
        assert_eq!(gray.into_luma_alpha8()[(0, 0)].0, [255, 255]);
    }

    #[test]
    fn other_pictures_stay_as_they_are() {
        // 10 bits at the upper end of 16, as some cameras leave them.
        assert_eq!(bits_used(&ramp(10, 6)), 16);
        let eight = DynamicImage::new_luma8(3, 2);
        assert_eq!(bits_used(&eight), 8);
        assert_eq!(to_8_bits(eight.clone(), 8), eight);
        assert_eq!(bits_used(&DynamicImage::new_rgb16(2, 2)), 8);
    }
}
