//! Corners: FAST (Rosten & Drummond 2006), ranked by Harris's measure (Harris & Stephens 1988), as
//! Rublee et al. 2011, Sec. 3.1, do.

use image::GrayImage;
use imageproc::corners::corners_fast9;

/// Weight of the squared trace (Harris & Stephens 1988).
const HARRIS_K: f32 = 0.04;
/// Half the side of the block that gradients are summed over, px.
const HARRIS_RADIUS_PX: i32 = 3;

/// A corner of a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    pub position_px: [i32; 2],
    pub response: f32,
}

/// Corners at least `border_px` inside, row by row, the best of each 3x3 px by Harris's measure.
pub fn corners(picture: &GrayImage, threshold: u8, border_px: i32) -> Vec<Corner> {
    let [width, height] = [picture.width(), picture.height()].map(|side| side as i32);
    let inside = |p: i32, side: i32| (border_px..side - border_px).contains(&p);
    let found: Vec<Corner> = corners_fast9(picture, threshold)
        .into_iter()
        .map(|corner| [corner.x as i32, corner.y as i32])
        .filter(|[x, y]| inside(*x, width) && inside(*y, height))
        .map(|position_px| Corner {
            position_px,
            response: harris(picture, position_px),
        })
        .collect();
    let mut responses = vec![f32::NEG_INFINITY; (width * height) as usize];
    let index = |[x, y]: [i32; 2]| (y * width + x) as usize;
    for corner in &found {
        responses[index(corner.position_px)] = corner.response;
    }
    let best = |corner: &Corner| {
        let [x, y] = corner.position_px;
        let here = index([x, y]);
        (y - 1..=y + 1).all(|v| {
            (x - 1..=x + 1).all(|u| {
                let there = index([u, v]);
                // Of equals, the first.
                let other = responses[there];
                other < corner.response || other == corner.response && there >= here
            })
        })
    };
    found.iter().copied().filter(best).collect()
}

/// det - k trace^2 of the summed products of Sobel gradients, luma 0 to 1.
fn harris(picture: &GrayImage, [cx, cy]: [i32; 2]) -> f32 {
    let at = |x: i32, y: i32| f32::from(picture.get_pixel(x as u32, y as u32).0[0]) / 255.0;
    let [mut xx, mut xy, mut yy] = [0.0f32; 3];
    for y in cy - HARRIS_RADIUS_PX..=cy + HARRIS_RADIUS_PX {
        for x in cx - HARRIS_RADIUS_PX..=cx + HARRIS_RADIUS_PX {
            let column = |u: i32| at(u, y - 1) + 2.0 * at(u, y) + at(u, y + 1);
            let row = |v: i32| at(x - 1, v) + 2.0 * at(x, v) + at(x + 1, v);
            let [gx, gy] = [column(x + 1) - column(x - 1), row(y + 1) - row(y - 1)];
            xx += gx * gx;
            xy += gx * gy;
            yy += gy * gy;
        }
    }
    let trace = xx + yy;
    xx * yy - xy * xy - HARRIS_K * trace * trace
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_a_square_are_found_and_nothing_else() {
        let picture = GrayImage::from_fn(60, 50, |x, y| {
            let inside = (20..40).contains(&x) && (15..35).contains(&y);
            image::Luma([if inside { 200 } else { 50 }])
        });
        let mut found: Vec<[i32; 2]> = corners(&picture, 20, 5)
            .iter()
            .map(|corner| corner.position_px)
            .collect();
        found.sort_unstable();
        // Harris's measure is greatest within a pixel of where the edges meet.
        let near = |a: [i32; 2], b: [i32; 2]| (a[0] - b[0]).abs() <= 2 && (a[1] - b[1]).abs() <= 2;
        for corner in [[20, 15], [20, 34], [39, 15], [39, 34]] {
            assert!(found.iter().any(|f| near(*f, corner)), "{found:?}");
        }
        let stray = |f: &&[i32; 2]| {
            ![[20, 15], [20, 34], [39, 15], [39, 34]]
                .iter()
                .any(|corner| near(**f, *corner))
        };
        assert_eq!(found.iter().filter(stray).count(), 0, "{found:?}");
    }
}
