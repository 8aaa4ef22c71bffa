//! `tectum water`: an eye calibrated in air as it will be in water.

use std::path::PathBuf;

use anyhow::bail;
use serde_json::json;
use tectum_optics::{CalibratedEye, FrontElement, InWater, Medium};

use crate::files;
use crate::report::Report;

/// Predicts from a calibration in air how an eye sees in water
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum water eye.toml --air-deg 105 --water-deg 77.9 -o eye-water.toml\n  \
    tectum water eye.toml --kappa 0.694 -o eye-water.toml\n\n\
    The front of the lens is described by one number, kappa: 0 is a dome, 1 a flat port. One ray \
    known in air and in water gives it, such as the rim of the picture: half of both fields of \
    view. The result is a prediction: for measurements calibrate in water.")]
pub struct Args {
    /// Eye, calibrated in air: eye file, or a calibration of OCamCalib, Kalibr, OpenCV or Basalt with one camera
    eye: PathBuf,
    /// Shape of the lens's front, 0 (dome) to 1 (flat port)
    #[arg(
        long,
        conflicts_with_all = ["air_deg", "water_deg"],
        required_unless_present = "air_deg",
        allow_negative_numbers = true
    )]
    kappa: Option<f64>,
    /// A known angle off the axis in air, degrees
    #[arg(
        long,
        value_name = "DEG",
        requires = "water_deg",
        allow_negative_numbers = true
    )]
    air_deg: Option<f64>,
    /// Angle off the axis in water of the same pixel, degrees
    #[arg(
        long,
        value_name = "DEG",
        requires = "air_deg",
        allow_negative_numbers = true
    )]
    water_deg: Option<f64>,
    /// Eye to write
    #[arg(short, long, value_name = "EYE.toml")]
    output: PathBuf,
}

/// Converts and writes.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let air = files::eye(&args.eye)?;
    if air.medium != Medium::Air {
        bail!(
            "{}: it was calibrated in {}: needed is an eye calibrated in air",
            args.eye.display(),
            air.medium
        );
    }
    let front = match (args.kappa, args.air_deg, args.water_deg) {
        (None, Some(air_deg), Some(water_deg)) => {
            FrontElement::from_angles(air_deg.to_radians(), water_deg.to_radians())?
        }
        // Without angles clap asks for kappa; NaN is refused as any wrong number.
        (kappa, ..) => FrontElement::new(kappa.unwrap_or(f64::NAN))?,
    };
    let found = front.in_water(&air.eye)?;
    let label = format!("prediction for water, kappa {:.4}", front.kappa());
    let water = CalibratedEye {
        medium: Medium::Water,
        eye: found.eye.clone(),
        calibration: air.calibration.clone().map(|mut calibration| {
            calibration.made_by = format!("{label}, from: {}", calibration.made_by);
            // They are of parameters that the new lens does not have.
            calibration.standard_errors.clear();
            calibration
        }),
        remarks: Vec::new(),
    };
    let text = format!(
        "# {label}. For measurements calibrate in water.\n{}",
        water.to_toml()?
    );
    files::check_outputs([&args.output], [&args.eye])?;
    files::write(&args.output, text.as_bytes())?;
    let widest = [&air, &water].map(|eye| 2.0 * eye.eye.field.widest_rad().to_degrees());
    Ok(report(args, front, &found, widest))
}

fn report(args: &Args, front: FrontElement, found: &InWater, fields_deg: [f64; 2]) -> Report {
    let [air_deg, water_deg] = fields_deg;
    let misfit_deg = found.misfit_rad.to_degrees();
    let text = format!(
        "{}: PREDICTION for water, kappa {:.4}\n\
         field     {air_deg:.2} degrees in air, {water_deg:.2} in water\n\
         near the axis angles shrink to {:.4}\n\
         lens      polynomial of degree {}, within {misfit_deg:.5} degrees of the model\n\
         For measurements calibrate in water: the lens's pupil wanders, which no such model holds",
        args.output.display(),
        front.kappa(),
        front.paraxial_ratio(),
        found.degree,
    );
    let json = json!({
        "eye": args.output.display().to_string(),
        "prediction": true,
        "kappa": front.kappa(),
        "field_air_deg": air_deg,
        "field_water_deg": water_deg,
        "paraxial_ratio": front.paraxial_ratio(),
        "degree": found.degree,
        "misfit_deg": misfit_deg,
    });
    Report::new(text, json)
}
