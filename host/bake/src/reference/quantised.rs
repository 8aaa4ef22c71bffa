//! The core's result by definition: f64 on the table's own numbers.

use rayon::prelude::*;
use tectum_core::{Eye, Sampler, Tables};
use tectum_tables::RunKind;

use super::has_chroma;
use super::planes::Planes;
use super::position::{position_q8, round};
use super::tone::toned;
use crate::{Format, Pair};

/// Stitches a whole picture slowly. Equal to the core bit for bit.
///
/// # Panics
/// If frames are smaller than the table states.
pub fn stitch(tables: &Tables<'_>, format: Format, sampler: Sampler, pair: Pair<'_>) -> Vec<u8> {
    let decode = |eye, bytes| {
        let size = tables.source_size_px(eye)?.map(usize::from);
        Some(Planes::decode(format, size, bytes))
    };
    let eyes = [decode(Eye::Left, pair.left), decode(Eye::Right, pair.right)];
    let height = tables.output_height_px();
    let rows = (0..height)
        .into_par_iter()
        .map(|y| row(tables, &eyes, format, sampler, usize::from(y)));
    let rows: Vec<Planes> = rows.collect();
    let size_px = [tables.output_width_px(), height].map(usize::from);
    let mut out = Planes::decode(format, size_px, &vec![0; format.picture_bytes(size_px)]);
    for (channel, plane) in out.planes.iter_mut().enumerate() {
        // The first of the rows that share values gives them.
        let rows = rows.iter().step_by(plane.cell_px[1]);
        plane.values = rows
            .flat_map(|row| &row.planes[channel].values)
            .copied()
            .collect();
    }
    out.encode(format)
}

fn row(
    tables: &Tables<'_>,
    eyes: &[Option<Planes>; 2],
    format: Format,
    sampler: Sampler,
    y: usize,
) -> Planes {
    let width = usize::from(tables.output_width_px());
    let blank = vec![0; format.picture_bytes([width, 1])];
    let mut out = Planes::decode(format, [width, 1], &blank);
    for run in tables.runs(y as u16) {
        let mut ramp = match run.kind {
            RunKind::Blend(ramp) => Some(ramp),
            _ => None,
        };
        let shown: &[Eye] = match run.kind {
            RunKind::Void => &[],
            RunKind::Left => &[Eye::Left],
            RunKind::Right => &[Eye::Right],
            RunKind::Blend(_) => &Eye::BOTH,
        };
        for x in run.start as usize..(run.start + run.len) as usize {
            let positions = Eye::BOTH.map(|eye| {
                let position = || position_q8(tables, eye, x, y).expect("runs lie in the mesh");
                shown.contains(&eye).then(position)
            });
            for (channel, plane) in out.planes.iter_mut().enumerate() {
                // The other pixels of a pair have no chroma of their own.
                if !x.is_multiple_of(plane.cell_px[0]) {
                    continue;
                }
                let i = x / plane.cell_px[0];
                let value = |eye: Eye| {
                    let planes = eyes[eye as usize].as_ref().expect("runs show known eyes");
                    let at = positions[eye as usize].expect("asked for where it is shown");
                    let value = sample(planes, channel, at, sampler);
                    toned(tables, eye, format, channel, value)
                };
                plane.values[i] = match run.kind {
                    RunKind::Void => background(format, channel),
                    RunKind::Left => value(Eye::Left),
                    RunKind::Right => value(Eye::Right),
                    RunKind::Blend(_) => {
                        let w = ramp.map_or(0.0, |r| f64::from(r.left_weight()) / 256.0);
                        round(w * value(Eye::Left) + (1.0 - w) * value(Eye::Right))
                    }
                };
            }
            if let Some(ramp) = &mut ramp {
                ramp.step();
            }
        }
    }
    out
}

fn background(format: Format, channel: usize) -> f64 {
    if has_chroma(format) && channel > 0 {
        128.0
    } else {
        0.0
    }
}

/// Value of a channel at a position, rounded half up.
fn sample(planes: &Planes, channel: usize, at_q8: [i32; 2], sampler: Sampler) -> f64 {
    let plane = &planes.planes[channel];
    let [step_x, step_y] = plane.cell_px.map(|px| px as i32);
    let (width, height) = (plane.width, plane.values.len() / plane.width);
    // What is larger than a pixel stands for its missing neighbour; a position outside of the frame
    // is no position.
    let place = |at: i32, size: usize, step: i32| {
        let greatest = if step > 1 { size - 1 } else { usize::MAX };
        (at as usize).min(greatest)
    };
    let get = |x: i32, y: i32| {
        let (x, y) = (place(x, width, step_x), place(y, height, step_y));
        assert!(x < width && y < height, "a position outside of the frame");
        plane.values[y * width + x]
    };
    let [x, y] = at_q8;
    match sampler {
        Sampler::Nearest => get(((x + 128) >> 8) / step_x, ((y + 128) >> 8) / step_y),
        Sampler::Bilinear => {
            let [x, y] = [x / step_x, y / step_y];
            let [fx, fy] = [x, y].map(|v| f64::from(v & 255) / 256.0);
            let [x, y] = [x >> 8, y >> 8];
            let upper = (1.0 - fx) * get(x, y) + fx * get(x + 1, y);
            let lower = (1.0 - fx) * get(x, y + 1) + fx * get(x + 1, y + 1);
            round((1.0 - fy) * upper + fy * lower)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;

    #[test]
    fn only_cells_larger_than_a_pixel_stand_for_a_neighbour_that_is_missing() {
        let size_px = [4, 4];
        for format in [Format::Gray8, Format::Rgb8, Format::Yuyv, Format::Nv12] {
            let bytes = vec![9; format.picture_bytes(size_px)];
            let planes = Planes::decode(format, size_px, &bytes);
            for (channel, plane) in planes.planes.iter().enumerate() {
                for axis in [0, 1] {
                    // In the middle of the last pixel but one, and of the last one.
                    for (last, is_inside) in [(2, true), (3, plane.cell_px[axis] > 1)] {
                        let mut at_q8 = [256; 2];
                        at_q8[axis] = last << 8 | 128;
                        let sampled =
                            catch_unwind(|| sample(&planes, channel, at_q8, Sampler::Bilinear));
                        let due = is_inside.then_some(9.0);
                        assert_eq!(sampled.ok(), due, "{format:?} {channel} {at_q8:?}");
                    }
                }
            }
        }
    }
}
