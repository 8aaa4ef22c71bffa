//! The emulated machine.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, bail};
use wait_timeout::ChildExt;

/// The whole run takes two to three minutes where nothing else is going on.
const LONGEST: Duration = Duration::from_secs(900);

/// Boots and returns what came over the serial line.
pub fn boot(kernel: &Path, initramfs: &Path) -> anyhow::Result<String> {
    let log = initramfs.with_file_name("serial.txt");
    let mut machine = Command::new("qemu-system-x86_64")
        .args(["-accel", "tcg,thread=multi", "-smp", "2", "-m", "1024"])
        .args(["-nographic", "-no-reboot", "-nic", "none"])
        .arg("-kernel")
        .arg(kernel)
        .arg("-initrd")
        .arg(initramfs)
        .args(["-append", "console=ttyS0 quiet panic=1 rdinit=/init"])
        .stdin(Stdio::null())
        .stdout(File::create(&log)?)
        .stderr(Stdio::inherit())
        .spawn()
        .context("qemu-system-x86_64")?;
    let ended = machine.wait_timeout(LONGEST)?;
    let mut bytes = Vec::new();
    File::open(&log)?.read_to_end(&mut bytes)?;
    let said = String::from_utf8_lossy(&bytes).replace('\r', "");
    if ended.is_none() {
        machine.kill()?;
        machine.wait()?;
        bail!("the machine did not end within {LONGEST:?}; it said:\n{said}");
    }
    Ok(said)
}
