//! Colours of both eyes brought together: curves that the core's tone tables hold.
