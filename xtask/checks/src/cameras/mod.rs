//! `cargo xtask cameras`: the built program with virtual cameras of the Linux kernel (vivid), in an
//! emulated machine, and with a driver of our own, on this one.

mod frames;
mod image;
mod judge;
mod machine;
mod preloaded;

use anyhow::bail;
use xtask::packages::{self, CAMERA_BUILD, CAMERA_MACHINE};
use xtask::{Outcome, target_dir};

/// Boots with the built program, reads what the machine says.
pub fn run() -> anyhow::Result<Outcome> {
    if cfg!(not(target_arch = "x86_64")) {
        return Ok(Outcome::Skipped(
            "the emulated machine is an x86-64".to_owned(),
        ));
    }
    if !packages::are_there(CAMERA_BUILD) {
        return Ok(Outcome::Skipped(packages::advice(CAMERA_BUILD)));
    }
    let folder = target_dir("cameras");
    let program = target_dir("debug").join("tectum");
    if !program.exists() {
        bail!("{} is not built", program.display());
    }
    if !preloaded::check(&folder, &program)? {
        println!("  there is no C compiler for the driver of our own: left out");
    }
    if !packages::are_there(CAMERA_MACHINE) {
        return Ok(Outcome::Skipped(packages::advice(CAMERA_MACHINE)));
    }
    let kernel = match image::kernel(&folder) {
        Ok(kernel) => kernel,
        Err(error) => {
            let why = format!("Debian's kernel package cannot be had: {error:#}");
            return Ok(Outcome::Skipped(why));
        }
    };
    let frames = frames::prepare(&folder)?;
    let initramfs = image::initramfs(&folder, &kernel, &program, &frames)?;
    let said = machine::boot(&kernel.file, &initramfs)?;
    judge::judge(&said)?;
    Ok(Outcome::Passed)
}
