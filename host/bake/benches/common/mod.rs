//! What the benches share: the paper's fish, baked, and thread pools.

use std::path::Path;

use criterion::Criterion;
use rayon::ThreadPool;
use tectum_bake::BakeOptions;
use tectum_optics::{Projection, Rig};

/// A fish and a picture of it.
pub struct Case {
    /// Width and height of the equirect output, px.
    pub output_px: [u16; 2],
    /// Rig file under `tables/rigs`.
    pub rig: &'static str,
    /// Greatest error of a source position, px.
    pub max_error_px: f64,
}

/// The table for small boards.
pub const SMALL: Case = Case {
    output_px: [640, 320],
    rig: "paper-fish",
    max_error_px: 0.05,
};

impl Case {
    pub fn name(&self) -> String {
        let [width, height] = self.output_px;
        format!("{width}x{height}")
    }

    pub fn load(&self) -> (Rig, BakeOptions) {
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tables/rigs")
            .join(format!("{}.toml", self.rig));
        let options = BakeOptions {
            output: Projection::Equirect
                .output_map(self.output_px)
                .expect("a sound size"),
            max_error_px: self.max_error_px,
            feather_rad: 4f64.to_radians(),
        };
        (Rig::load(&file).expect("a shipped rig"), options)
    }
}

/// One thread, and all of them.
pub fn pools() -> [(&'static str, ThreadPool); 2] {
    // 0 is rayon's word for as many threads as there are cores.
    [("1 thread", 1), ("all threads", 0)].map(|(name, threads)| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        (name, pool.build().expect("threads"))
    })
}

pub fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(20)
        .measurement_time(std::time::Duration::from_secs(2))
        .warm_up_time(std::time::Duration::from_millis(500))
        .configure_from_args()
}
