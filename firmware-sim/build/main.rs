//! Link arguments, and the tables and frames that the programs carry in flash.

mod tables;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use tectum_fixture::frames::{self, Layout};
use tectum_fixture::random;
use tectum_tables::{Eye, Tables};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-env-changed=TECTUM_BOARD");

    let out = PathBuf::from(env::var("OUT_DIR")?);
    let board = env::var("TECTUM_BOARD")?;
    let file = tectum_fixture::table_file(&board).ok_or(format!("no board `{board}`"))?;
    let file = Path::new("..").join(file);
    println!("cargo:rerun-if-changed={}", file.display());
    let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    fs::write(out.join("picture.tct"), &bytes)?;
    let scaled = tectum_fixture::scaled_table_file(&board).ok_or("no table with scales")?;
    let scaled = Path::new("..").join(scaled);
    println!("cargo:rerun-if-changed={}", scaled.display());
    fs::copy(&scaled, out.join("scaled.tct"))
        .map_err(|error| format!("{}: {error}", scaled.display()))?;
    let toned = tectum_fixture::toned(&bytes).map_err(|error| format!("toned: {error}"))?;
    fs::write(out.join("toned.tct"), toned)?;

    let picture = Tables::parse(&bytes).map_err(|error| format!("{}: {error}", file.display()))?;
    for (name, bytes) in tables::one_kind(&picture)? {
        fs::write(out.join(name).with_extension("tct"), bytes)?;
    }
    write_sizes(&picture, &out)?;
    write_frames(&picture, &out)?;
    write_random(&picture, &out)
}

/// As many random tables as the smallest board has flash for.
const RANDOM_TABLES: u64 = 48;
/// Their largest output, px.
const RANDOM_PX: [u16; 2] = [70, 9];

/// Random tables with the CRC-32 of what this machine makes of them.
fn write_random(picture: &Tables, out: &Path) -> Result<(), Box<dyn Error>> {
    let frame = |layout, eye| {
        let [width, height] = picture.source_size_px(eye).unwrap_or_default();
        frames::bytes(layout, eye as u32, width, height).collect::<Vec<u8>>()
    };
    let pairs = Layout::ALL.map(|layout| [Eye::Left, Eye::Right].map(|eye| frame(layout, eye)));
    let pair = |layout: Layout| pairs[layout as usize].each_ref().map(Vec::as_slice);
    let mut room = vec![0; 3 * RANDOM_PX.map(usize::from).iter().product::<usize>()];
    let mut blob = Vec::new();
    for seed in 0..RANDOM_TABLES {
        let bytes = tectum_exact::table(&mut tectum_exact::rng(seed), RANDOM_PX).to_bytes()?;
        let tables = Tables::parse(&bytes)?;
        let crc = random::checksum(&tables, pair, &mut room)
            .map_err(|error| format!("random table {seed}: {error:?}"))?;
        blob.extend(crc.to_le_bytes());
        blob.extend((bytes.len() as u32).to_le_bytes());
        blob.extend(bytes);
    }
    Ok(fs::write(out.join("random.bin"), blob)?)
}

fn write_sizes(tables: &Tables, out: &Path) -> Result<(), Box<dyn Error>> {
    let pixels = u32::from(tables.output_width_px()) * u32::from(tables.output_height_px());
    let text = format!(
        "/// Bytes of an output picture in the largest format.\npub const ROOM_BYTES: usize = {};\n",
        pixels * 3
    );
    Ok(fs::write(out.join("sizes.rs"), text)?)
}

fn write_frames(tables: &Tables, out: &Path) -> Result<(), Box<dyn Error>> {
    for (eye, name) in [(Eye::Left, "left"), (Eye::Right, "right")] {
        let [width, height] = tables
            .source_size_px(eye)
            .ok_or("a table must show both eyes")?;
        for layout in Layout::ALL {
            let bytes: Vec<u8> = frames::bytes(layout, eye as u32, width, height).collect();
            fs::write(out.join(format!("{}_{name}.raw", layout.name())), bytes)?;
        }
    }
    Ok(())
}
