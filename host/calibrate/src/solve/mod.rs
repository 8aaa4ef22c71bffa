//! From labelled corners to a camera model.
