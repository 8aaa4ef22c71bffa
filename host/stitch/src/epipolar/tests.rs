//! Synthetic rays with known truth.
