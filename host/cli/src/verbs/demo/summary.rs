//! Every figure that the demo claims, for a script and for a person.

use serde::Serialize;
use tectum_bake::{Report as CostSheet, Verification};

use super::angles::AngleCheck;
use super::coverage::{FieldOfView, Shares};
use crate::report::max_rms;

/// What was done and measured.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Name of the rig.
    pub rig: String,
    /// Range at which the picture is exact, m; `None` for infinity.
    pub stitch_distance_m: Option<f64>,
    /// Width and height of the stitched picture, px.
    pub output_px: [u16; 2],
    /// The table's cost sheet.
    pub table: CostSheet,
    /// The core against both references on the eyes' pictures.
    pub verification: Verification,
    /// What the eyes see.
    pub field_of_view: FieldOfView,
    /// Looked-up directions against the pool's truth.
    pub angles: Angles,
    /// The larger picture, if it was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub large: Option<Large>,
    /// The fish as it sees in water, if the rig is the one inside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_water: Option<InWater>,
    /// Files written beside this one.
    pub files: Vec<String>,
}

/// Both checks of angles.
#[derive(Debug, Serialize)]
pub struct Angles {
    /// Corners of boards and markers in the raw pictures.
    pub printed_corners: AngleCheck,
    /// Pixels of the stitched picture.
    pub stitched_pixels: AngleCheck,
}

/// The larger picture.
#[derive(Debug, Serialize)]
pub struct Large {
    /// Width and height, px.
    pub output_px: [u16; 2],
    /// Its table's cost sheet.
    pub table: CostSheet,
    /// Bytes of it that differ from the reference.
    pub mismatches: usize,
}

/// The fish as it really sees in water, on the part of the inclined view that its eyes see.
#[derive(Debug, Serialize)]
pub struct InWater {
    /// Name of the rig.
    pub rig: String,
    /// Width and height, px.
    pub output_px: [u16; 2],
    /// Yaw of the right and the left border about the plane of both axes, degrees.
    pub yaw_deg: [f64; 2],
    /// Pitch of the upper and the lower border about that plane, degrees.
    pub pitch_deg: [f64; 2],
    /// Share of its pixels that show neither eye, 0 to 1.
    pub void_share: f64,
    /// What its eyes see.
    pub field_of_view: FieldOfView,
    /// Its table's cost sheet.
    pub table: CostSheet,
    /// Bytes of it that differ from the reference.
    pub mismatches: usize,
}

impl Summary {
    /// For a person: rows of a name and a figure.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let bytes = &self.table.bytes;
        let formats: Vec<_> = self
            .verification
            .formats
            .iter()
            .map(|f| f.format.name())
            .collect();
        let mut rows = vec![
            (
                "table",
                format!(
                    "{} bytes: meshes {} + {}, runs {}, directions and text {}",
                    bytes.total, bytes.mesh_left, bytes.mesh_right, bytes.runs, bytes.other
                ),
            ),
            (
                "coordinate error",
                max_rms(&self.table.coordinate_error_px, "px"),
            ),
            (
                "mismatches",
                format!(
                    "{} of {} bytes ({}; nearest and bilinear; both frames at once and one eye at \
                     a time)",
                    self.verification.mismatches,
                    self.verification.bytes_compared,
                    formats.join(", ")
                ),
            ),
            (
                "rounding",
                format!("{:.3} LSB max", self.verification.rounding_error_lsb),
            ),
        ];
        if let Some(error) = &self.verification.pixel_error_lsb {
            let text = format!("{:.2} LSB max, {:.3} LSB mean", error.max, error.mean);
            rows.push(("pixel error", text));
        }
        let shares = |s: &Shares, scale: f64, unit: &str| {
            format!(
                "{:.1} {unit} seen, {:.1} by both, {:.1} blind",
                scale * s.seen,
                scale * s.both,
                scale * s.blind
            )
        };
        let field = &self.field_of_view;
        rows.push(("sphere", shares(&field.sphere, 100.0, "%")));
        rows.push(("horizon", shares(&field.horizontal_deg, 1.0, "deg")));
        rows.push(("corners, raw", angles(&self.angles.printed_corners)));
        rows.push(("pixels, stitched", angles(&self.angles.stitched_pixels)));
        if let Some(large) = &self.large {
            let [width, height] = large.output_px;
            let text = format!(
                "{width}x{height} px, table {} bytes, {}, mismatches {}",
                large.table.bytes.total,
                max_rms(&large.table.coordinate_error_px, "px"),
                large.mismatches
            );
            rows.push(("large picture", text));
        }
        if let Some(water) = &self.in_water {
            let [width, height] = water.output_px;
            let text = format!(
                "{width}x{height} px, yaw {:.0} to {:.0}, pitch {:.0} to {:.0} deg about the plane of \
                 the axes, {:.1} % void; table {} bytes, {}, mismatches {}",
                water.yaw_deg[1],
                water.yaw_deg[0],
                water.pitch_deg[0],
                water.pitch_deg[1],
                100.0 * water.void_share,
                water.table.bytes.total,
                max_rms(&water.table.coordinate_error_px, "px"),
                water.mismatches
            );
            rows.push(("really in water", text));
            let field = &water.field_of_view;
            rows.push(("  sphere", shares(&field.sphere, 100.0, "%")));
            rows.push(("  horizon", shares(&field.horizontal_deg, 1.0, "deg")));
        }
        rows
    }

    /// How to read the angles.
    pub fn note(&self) -> String {
        let distance = match self.stitch_distance_m {
            Some(m) => format!("{m} m"),
            None => "infinity".into(),
        };
        let lenses = if self.in_water.is_some() {
            "The fish has ideal lenses here, which see 210 degrees even in water; \"really in water\" is \
             the same fish with these lenses bare, where 155.8 degrees are left. "
        } else {
            ""
        };
        format!(
            "{lenses}Angles: looked-up direction against the truth of the simulated pool. The stitched \
             picture is exact at {distance} from the body; what lies nearer or farther is off by \
             parallax, which is in the second figure."
        )
    }

    /// For a person: everything.
    pub fn text(&self) -> String {
        let [width, height] = self.output_px;
        let mut text = format!("{width}x{height} px from rig {:?}\n\n", self.rig);
        for (name, figure) in self.rows() {
            text += &format!("{name:<17} {figure}\n");
        }
        text + "\n" + &self.note() + "\n"
    }
}

fn angles(check: &AngleCheck) -> String {
    format!(
        "{} at {:.1} to {:.1} m: table {}; with parallax {}",
        check.count,
        check.range_m[0],
        check.range_m[1],
        max_rms(&check.table_deg, "deg"),
        max_rms(&check.with_parallax_deg, "deg"),
    )
}
