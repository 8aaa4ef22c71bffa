//! Shipped tables, baked again on this processor: the same to the byte.

use std::path::Path;

use tectum_bake::{BakeOptions, bake};
use tectum_optics::{Projection, Rig};

/// File, rig, output size, position error allowed (px), feather (degrees): as in
/// `tables/baked/recipes.toml`.
const TABLES: [(&str, &str, [u16; 2], f64, f64); 2] = [
    (
        "paper-fish-480x240.tct",
        "paper-fish-240.toml",
        [480, 240],
        0.05,
        4.0,
    ),
    (
        "paper-fish-640x320.tct",
        "paper-fish.toml",
        [640, 320],
        0.05,
        4.0,
    ),
];

#[test]
fn shipped_tables_are_baked_to_the_byte() {
    let tables = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables");
    for (file, rig, size_px, max_error_px, feather_deg) in TABLES {
        let rig = Rig::load(&tables.join("rigs").join(rig)).expect("a rig");
        let options = BakeOptions {
            output: Projection::Equirect.output_map(size_px).expect("a size"),
            max_error_px,
            feather_rad: feather_deg.to_radians(),
        };
        let shipped = std::fs::read(tables.join("baked").join(file)).expect("a table");
        assert!(
            bake(&rig, &options).expect("a table").bytes == shipped,
            "{file}"
        );
    }
}
