//! A corner's direction: towards the centroid of the luma around it (Rosin 1999; Rublee et al. 2011,
//! Eq. 1-3).

use image::GrayImage;

use super::PATCH_RADIUS_PX;

/// `atan2(m01, m10)` over the patch, rad; the patch lies inside the picture.
pub fn angle_rad(picture: &GrayImage, [cx, cy]: [i32; 2]) -> f32 {
    // Exact in integers: 709 pixels of at most 15 x 255.
    let [mut m10, mut m01] = [0i32; 2];
    for y in -PATCH_RADIUS_PX..=PATCH_RADIUS_PX {
        for x in -PATCH_RADIUS_PX..=PATCH_RADIUS_PX {
            if x * x + y * y <= PATCH_RADIUS_PX * PATCH_RADIUS_PX {
                let luma = picture.get_pixel((cx + x) as u32, (cy + y) as u32).0[0];
                m10 += x * i32::from(luma);
                m01 += y * i32::from(luma);
            }
        }
    }
    libm::atan2f(m01 as f32, m10 as f32)
}
