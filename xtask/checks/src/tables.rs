//! `cargo xtask tables`: the shipped tables, baked again and compared byte for byte.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use serde::Deserialize;
use tectum_bake::{BakeOptions, Baked, bake};
use tectum_optics::{Projection, Rig};

use xtask::repository;

/// Arguments of `cargo xtask tables`.
#[derive(clap::Args, Default)]
pub struct Args {
    /// Write what came instead of comparing it
    #[arg(long)]
    bless: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Recipes {
    table: Vec<Recipe>,
}

/// One shipped table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// File in `tables/baked`.
    pub file: String,
    /// File in `tables/rigs`.
    pub rig: String,
    /// Width and height of the equirect output.
    pub size_px: [u16; 2],
    max_error_px: f64,
    feather_deg: f64,
    scales_deg: Option<f64>,
}

impl Recipe {
    fn path(&self) -> PathBuf {
        folder().join(&self.file)
    }

    /// The rig it is baked from.
    pub fn rig(&self) -> anyhow::Result<Rig> {
        Ok(Rig::load(
            &repository().join("tables/rigs").join(&self.rig),
        )?)
    }

    /// Bakes the table.
    pub fn bake(&self) -> anyhow::Result<Baked> {
        let options = BakeOptions {
            output: Projection::Equirect.output_map(self.size_px)?,
            max_error_px: self.max_error_px,
            feather_rad: self.feather_deg.to_radians(),
        };
        let baked = bake(&self.rig()?, &options).with_context(|| self.file.clone())?;
        Ok(match self.scales_deg {
            Some(step_deg) => baked.with_scales(step_deg)?,
            None => baked,
        })
    }
}

/// The recipes of all shipped tables.
pub fn recipes() -> anyhow::Result<Vec<Recipe>> {
    let path = folder().join("recipes.toml");
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    Ok(toml::from_str::<Recipes>(&text)?.table)
}

fn folder() -> PathBuf {
    repository().join("tables/baked")
}

/// Runs `cargo xtask tables`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut different = Vec::new();
    for recipe in recipes()? {
        let bytes = recipe.bake()?.bytes;
        let shipped = fs::read(recipe.path()).unwrap_or_default();
        if bytes == shipped {
            println!("same {}: {} bytes", recipe.file, bytes.len());
        } else if args.bless {
            fs::write(recipe.path(), &bytes)?;
            println!("written {}: {} bytes", recipe.file, bytes.len());
        } else {
            different.push(recipe.file);
        }
    }
    if !different.is_empty() {
        bail!(
            "baked again, these differ from what is shipped (--bless): {}",
            different.join(", ")
        );
    }
    Ok(())
}
