//! Says whether the processor has the DSP instructions of Armv7E-M, for which stable Rust has no
//! `target_feature`: `cfg(arm_dsp)`.

use std::env::var;

/// Cortex-M cores of Armv8-M that always have them; on others they are an option.
const CORES: [&str; 3] = ["cortex-m55", "cortex-m85", "cortex-m52"];

fn main() {
    println!("cargo::rustc-check-cfg=cfg(arm_dsp, values(none(), \"optional\"))");
    println!("cargo::rerun-if-changed=build.rs");
    let target = var("TARGET").unwrap_or_default();
    let flags = var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let of_core = CORES
        .iter()
        .any(|core| flags.contains(&format!("target-cpu={core}")));
    let asked_for = flags.contains("+dsp");
    if target.starts_with("thumbv7em-") {
        println!("cargo::rustc-cfg=arm_dsp");
    } else if target.starts_with("thumbv8m.main-") && (of_core || asked_for) {
        println!("cargo::rustc-cfg=arm_dsp");
        // The assembler is told so too.
        println!("cargo::rustc-cfg=arm_dsp=\"optional\"");
    }
}
