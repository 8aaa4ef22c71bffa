//! Any byte string is a typed error or a table that is safe to run.
#![no_main]

// The file itself, not its crate: that one brings the host's crates along, minutes to build here.
#[path = "../../exact/src/hostile.rs"]
mod hostile;

use hostile::parse_and_run;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = parse_and_run(bytes);
    // The checksum would stop nearly every mutation: mend it and look behind it.
    let mut sealed = bytes.to_vec();
    if let Some(length) = sealed.get_mut(8..12) {
        length.copy_from_slice(&(bytes.len() as u32).to_le_bytes());
    }
    tectum_tables::builder::seal(&mut sealed);
    let _ = parse_and_run(&sealed);
});
