//! Hands the linker the memory map of the board named by `TECTUM_BOARD` (set in `boards/*.toml`).

use std::{env, error::Error, fs, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=TECTUM_BOARD");
    println!("cargo:rerun-if-changed=memory");
    let board = env::var("TECTUM_BOARD")
        .map_err(|_| "no board chosen: build with `--config boards/m4.toml`, m7 or m55")?;
    let map = match board.as_str() {
        "m4" | "m7" => "memory/mps2.x",
        "m55" => "memory/mps3-an547.x",
        other => return Err(format!("TECTUM_BOARD={other}: allowed are m4, m7, m55").into()),
    };
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::copy(map, out.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    Ok(())
}
