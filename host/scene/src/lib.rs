//! A ray-traced underwater pool with exact ground truth
