//! Local alignment along the seam, guided by structural similarity.
