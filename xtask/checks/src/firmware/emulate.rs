//! Runs a program under QEMU and decodes its defmt log.

use std::fs;
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use wait_timeout::ChildExt;

use super::board::Board;

/// The longest program takes a few seconds; a hanging one is a failure.
const TIME_LIMIT: Duration = Duration::from_secs(180);

/// Lines the program logged. Fails unless it ended itself with exit code 0.
pub fn run(board: Board, program: &Path) -> anyhow::Result<Vec<String>> {
    let mut log = tempfile::tempfile().context("making a file for the log")?;
    let (cpu, machine) = board.qemu();
    let mut qemu = Command::new("qemu-system-arm")
        .args(["-cpu", cpu, "-machine", machine, "-icount", "shift=0"])
        .args(["-display", "none", "-serial", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(program)
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .spawn()
        .context("starting qemu-system-arm")?;
    let status = qemu.wait_timeout(TIME_LIMIT)?;
    if status.is_none() {
        qemu.kill()
            .and_then(|()| qemu.wait())
            .context("stopping qemu-system-arm")?;
    }

    let mut bytes = Vec::new();
    log.rewind()?;
    log.read_to_end(&mut bytes)?;
    let lines = decode(&fs::read(program)?, &bytes)?;
    match status {
        Some(status) if status.success() => Ok(lines),
        Some(status) => bail!("{status}; its log:\n{}", lines.join("\n")),
        None => bail!(
            "no end after {TIME_LIMIT:?}; its log:\n{}",
            lines.join("\n")
        ),
    }
}

/// Text of each defmt frame in `log`.
fn decode(program: &[u8], log: &[u8]) -> anyhow::Result<Vec<String>> {
    let table =
        Table::parse(program)?.ok_or_else(|| anyhow!("the program has no defmt section"))?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(log);
    let mut lines = Vec::new();
    while let Some(line) = next_line(&mut *decoder)? {
        lines.push(line);
    }
    Ok(lines)
}

fn next_line(decoder: &mut dyn StreamDecoder) -> anyhow::Result<Option<String>> {
    match decoder.decode() {
        Ok(frame) => {
            let message = frame.display_message().to_string();
            let level = frame
                .level()
                .map(|level| format!("{}: ", level.as_str().to_uppercase()));
            Ok(Some(level.unwrap_or_default() + &message))
        }
        Err(DecodeError::UnexpectedEof) => Ok(None),
        Err(DecodeError::Malformed) => bail!("the log holds a malformed defmt frame"),
    }
}
