//! A lens whose centre has row and column swapped: other programs write x first, OCamCalib the row.

use nalgebra::Vector3;

use crate::Eye;

/// A centre farther from the frame's middle than this, in sides of the frame, is odd.
const ODD: f64 = 0.1;
/// A centre nearer to the frame's middle than this, in sides of the frame, is as lenses are built in.
const USUAL: f64 = 0.05;
/// Part of the field's angle up to which a circle is drawn: at its very end a model may have no answer.
const INSIDE: f64 = 0.99;

/// What to tell of the eye `[name]` whose image circle leaves the frame where it would not with row and
/// column swapped.
pub(super) fn remark(eye: &Eye, name: &str) -> Option<String> {
    let given = eye.model.principal_point_px();
    let swapped = [given[1], given[0]];
    let sides = eye.size_px.map(f64::from);
    let off = |centre: [f64; 2]| {
        let off = [0, 1].map(|k| (centre[k] - (sides[k] - 1.0) / 2.0).abs() / sides[k]);
        off[0].max(off[1])
    };
    if off(given) < ODD || off(swapped) > USUAL {
        return None;
    }
    let angle = INSIDE * eye.field.half_angle_rad(0.0);
    let ray = Vector3::new(libm::sin(angle), 0.0, libm::cos(angle));
    let edge = eye.model.project(&ray).ok()?;
    let radius = libm::hypot(edge[0] - given[0], edge[1] - given[1]);
    // How far the circle reaches beyond the four sides.
    let beyond = |centre: [f64; 2]| -> f64 {
        let rooms = [0, 1].map(|k| [centre[k], sides[k] - 1.0 - centre[k]]);
        let over = rooms.as_flattened().iter().map(|room| radius - room);
        over.map(|px| px.max(0.0)).sum()
    };
    (beyond(swapped) < beyond(given)).then(|| {
        format!(
            "[{name}] the lens's centre, x {:.1} and y {:.1} px, lies far from the middle of {}x{} px, and \
             its image circle of {radius:.0} px leaves the frame: are row and column swapped? \
             centre_row_column has the row (y) first, centre_px has x first",
            given[0], given[1], eye.size_px[0], eye.size_px[1]
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Field;
    use crate::camera::{CameraModel, Equidistant};

    fn eye(size_px: [u16; 2], centre: [f64; 2]) -> Eye {
        Eye {
            size_px,
            model: CameraModel::Equidistant(Equidistant::new(250.0, centre).unwrap()),
            field: Field::new(vec![75f64.to_radians()]).unwrap(),
        }
    }

    #[test]
    fn a_swapped_centre_is_noticed_and_others_are_not() {
        let told = remark(&eye([960, 720], [362.0, 478.0]), "left").unwrap();
        assert!(
            told.contains("[left]") && told.contains("swapped"),
            "{told}"
        );
        for (size_px, centre) in [
            ([960, 720], [478.0, 362.0]),
            // Decentred, but not by a swap.
            ([960, 720], [400.0, 300.0]),
            // Two circles in one picture.
            ([1520, 760], [380.0, 379.5]),
            ([1520, 760], [1140.0, 379.5]),
            // Square, and a circle that fits wherever it is.
            ([720, 720], [350.0, 372.0]),
            ([3000, 2400], [1200.0, 1500.0]),
        ] {
            assert_eq!(remark(&eye(size_px, centre), "left"), None, "{centre:?}");
        }
    }
}
