//! SuperPoint (DeTone, Malisiewicz & Rabinovich 2018) with weights that the user supplies.
//!
//! The network is an ONNX file with one input, luma 0 to 1 of shape `1 x 1 x H x W`, and two
//! outputs: scores `1 x 65 x H/8 x W/8` and descriptions `1 x D x H/8 x W/8`. H and W are cut to
//! multiples of 8. What the outputs mean is decoded here: it is no part of the network. Behind
//! the cargo feature `superpoint`, because the runtime is much to compile.

#[cfg(any(feature = "superpoint", test))]
mod decode;
#[cfg(feature = "superpoint")]
mod network;

#[cfg(feature = "superpoint")]
pub use network::SuperPoint;
