//! no_std core of Tectum: stitches two fisheye frames from precomputed fixed-point tables
