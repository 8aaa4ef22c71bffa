//! What can be wrong with a scene, a ray or a picture size.

/// Why a scene was refused, a ray could not be traced or a picture could not be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A number is outside its range or is not a number.
    #[error("{name} is {value}, allowed is {min} to {max}")]
    OutOfRange {
        /// Path of the value in the description, unit included, such as `boards[1].square_mm`.
        name: String,
        /// The refused value.
        value: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// The two ends of a pole are the same point.
    #[error("solids[{index}]: from_m and to_m are the same point, a pole needs a length")]
    PoleWithoutLength {
        /// Index of the pole among the solids.
        index: usize,
    },
    /// A marker dictionary that this crate does not carry.
    #[error("markers[{index}].dictionary is \"{name}\", allowed is \"DICT_4X4_50\"")]
    UnknownDictionary {
        /// Index of the marker.
        index: usize,
        /// The refused name.
        name: String,
    },
    /// A picture without pixels, or with more than fit in memory.
    #[error("picture size is {width}x{height}, allowed is 1x1 to {max_pixels} pixels in all")]
    PictureSize {
        /// Width asked for, px.
        width: u32,
        /// Height asked for, px.
        height: u32,
        /// Largest allowed number of pixels.
        max_pixels: u64,
    },
    /// A ray with a coordinate that is infinite or not a number, or without a direction.
    #[error("the ray from {origin_m:?} along {direction:?} is not finite")]
    RayNotFinite {
        /// Origin of the ray, world, m.
        origin_m: [f64; 3],
        /// Direction of the ray, world.
        direction: [f64; 3],
    },
    /// A ray that starts outside the pool (or, in water, above the surface).
    #[error("the ray starts at {origin_m:?} m, outside the pool: allowed is ±{half_size_m:?} m")]
    RayOutside {
        /// Origin of the ray, world, m.
        origin_m: [f64; 3],
        /// Half the size of the volume that a camera may be in, along x, y and z, m.
        half_size_m: [f64; 3],
    },
}
