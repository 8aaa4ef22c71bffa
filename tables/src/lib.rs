//! The table format of Tectum: layout, proven zero-copy view, builder
