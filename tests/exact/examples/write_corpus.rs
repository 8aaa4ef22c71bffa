//! Writes the seeds of the fuzz corpus: a few random tables, whole and cut short.
//! `cargo run -p tectum-exact --example write_corpus`

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/tables");
    for seed in 0..8 {
        let builder = tectum_exact::table(&mut tectum_exact::rng(seed), [40, 12]);
        let bytes = builder.to_bytes().map_err(std::io::Error::other)?;
        std::fs::write(folder.join(format!("random-{seed}.tct")), &bytes)?;
        std::fs::write(
            folder.join(format!("cut-{seed}.tct")),
            &bytes[..bytes.len() / 2],
        )?;
    }
    Ok(())
}
