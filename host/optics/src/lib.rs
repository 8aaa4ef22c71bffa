//! Camera models, rays, projections and the rig file
