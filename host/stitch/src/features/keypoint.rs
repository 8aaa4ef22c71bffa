//! What every detector yields.

/// A feature's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// Position `[x, y]`, px.
    pub position_px: [f64; 2],
    /// Standard deviation of the blur at which it was found, px.
    pub scale_px: f32,
    /// Direction by which its description is turned, rad: 0 along x, positive towards y.
    pub angle_rad: f32,
    /// Strength; comparable within one detector.
    pub response: f32,
}

/// Descriptions, one a keypoint.
#[derive(Debug, Clone, PartialEq)]
pub enum Descriptors {
    /// Unit vectors, one after another; alike if their angle is small.
    Real {
        /// Numbers a vector.
        length: usize,
        /// All vectors.
        values: Vec<f32>,
    },
    /// 256 bits; alike if few differ.
    Binary(Vec<[u64; 4]>),
}

/// Keypoints and their descriptions, in the same order.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    /// Where.
    pub keypoints: Vec<Keypoint>,
    /// What.
    pub descriptors: Descriptors,
}

impl Descriptors {
    /// Number of descriptions.
    pub fn len(&self) -> usize {
        match self {
            Self::Real { length, values } => values.len() / (*length).max(1),
            Self::Binary(bits) => bits.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The descriptions with these indices.
    fn subset(&self, indices: &[usize]) -> Self {
        match self {
            Self::Real { length, values } => Self::Real {
                length: *length,
                values: indices
                    .iter()
                    .flat_map(|i| &values[i * length..][..*length])
                    .copied()
                    .collect(),
            },
            Self::Binary(bits) => Self::Binary(indices.iter().map(|i| bits[*i]).collect()),
        }
    }
}

impl Features {
    /// No features.
    pub fn none() -> Self {
        Self {
            keypoints: Vec::new(),
            descriptors: Descriptors::Binary(Vec::new()),
        }
    }

    /// Number of features.
    pub fn len(&self) -> usize {
        self.keypoints.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.keypoints.is_empty()
    }

    /// Those whose keypoint `keep` takes, perhaps with another position.
    pub fn filter_map(&self, keep: impl Fn(&Keypoint) -> Option<Keypoint>) -> Self {
        let (indices, keypoints): (Vec<usize>, Vec<Keypoint>) = self
            .keypoints
            .iter()
            .enumerate()
            .filter_map(|(i, keypoint)| Some((i, keep(keypoint)?)))
            .unzip();
        Self {
            keypoints,
            descriptors: self.descriptors.subset(&indices),
        }
    }
}

/// The indices of the `most` strongest responses, in their old order; of equals the first.
pub(crate) fn strongest(responses: &[f32], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..responses.len()).collect();
    order.sort_by(|a, b| responses[*b].total_cmp(&responses[*a]));
    order.truncate(most);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_keep_their_order() {
        assert_eq!(strongest(&[1.0, 5.0, 3.0, 5.0], 2), [1, 3]);
        assert_eq!(strongest(&[1.0, 5.0, 3.0, 5.0], 1), [1]);
        assert_eq!(strongest(&[1.0], 9), [0]);
    }
}
