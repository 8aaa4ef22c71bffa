//! The network, run by tract.

use std::path::{Path, PathBuf};

use image::GrayImage;
use tract_onnx::prelude::*;

use super::decode::{CELL_PX, Outputs};
use crate::features::{DetectorError, Features};

/// A SuperPoint network whose weights the user supplied.
#[derive(Debug, Clone)]
pub struct SuperPoint {
    file: PathBuf,
    model: InferenceModel,
}

impl SuperPoint {
    /// Reads the ONNX file.
    ///
    /// # Errors
    /// [`DetectorError::Network`] if it is none.
    pub fn load(file: &Path) -> Result<Self, DetectorError> {
        let model = onnx().model_for_path(file);
        Ok(Self {
            file: file.to_owned(),
            model: model.map_err(|error| failed(file, &error.to_string()))?,
        })
    }

    /// Keypoints of a picture whose position (px) `wanted` takes.
    ///
    /// # Errors
    /// [`DetectorError::Network`] if the network cannot be run on a picture of this size, or its
    /// outputs are not SuperPoint's.
    pub fn detect(
        &self,
        picture: &GrayImage,
        wanted: &(dyn Fn([f64; 2]) -> bool + Sync),
    ) -> Result<Features, DetectorError> {
        let cells = [picture.width(), picture.height()].map(|side| side as usize / CELL_PX);
        let outputs = self
            .run(picture, cells)
            .map_err(|error| failed(&self.file, &error.to_string()))?;
        let planes: Vec<_> = outputs
            .iter()
            .map(|tensor| tensor.to_plain_array_view::<f32>())
            .collect::<TractResult<_>>()
            .map_err(|error| failed(&self.file, &error.to_string()))?;
        let slices: Vec<&[f32]> = planes.iter().filter_map(|p| p.as_slice()).collect();
        let [scores, descriptions] = slices[..] else {
            return Err(failed(&self.file, "it has not two outputs"));
        };
        let outputs = Outputs {
            cells,
            scores,
            descriptions,
        };
        if !outputs.fit() {
            let reason = "its outputs are not 65 scores and a description for each 8x8 px";
            return Err(failed(&self.file, reason));
        }
        Ok(outputs.features(wanted))
    }

    fn run(&self, picture: &GrayImage, cells: [usize; 2]) -> TractResult<TVec<TValue>> {
        let [width, height] = cells.map(|n| n * CELL_PX);
        let shape = [1, 1, height, width];
        let model = self.model.clone();
        let model = model
            .with_input_fact(0, f32::fact(shape).into())?
            .into_optimized()?
            .into_runnable()?;
        let luma: Vec<f32> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x as u32, y as u32)))
            .map(|(x, y)| f32::from(picture.get_pixel(x, y).0[0]) / 255.0)
            .collect();
        model.run(tvec!(Tensor::from_shape(&shape, &luma)?.into()))
    }
}

fn failed(file: &Path, reason: &str) -> DetectorError {
    DetectorError::Network {
        file: file.display().to_string(),
        reason: reason.to_owned(),
    }
}
