//! Properties that every model has.
