//! On which sources each campaign passed last, so that the tests can tell whose part has changed.
//!
//! The record, `xtask/campaigns.txt`, is part of the repository: a line a campaign with its name and
//! the hash of its part's files.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use xtask::repository;

/// Whether a campaign's part is as it was when the campaign passed. False where git cannot tell.
pub fn is_current(name: &str, part: &[&str]) -> bool {
    let Ok(hash) = hash(part) else { return false };
    read().is_ok_and(|record| record.get(name) == Some(&hash))
}

/// Notes that a campaign has passed on the sources of that hash.
pub fn passed(name: &str, hash: String) -> anyhow::Result<()> {
    let mut record = read()?;
    record.insert(name.to_owned(), hash);
    let file = file();
    let new = file.with_extension("new");
    fs::write(&new, text(&record))?;
    fs::rename(&new, &file).with_context(|| file.display().to_string())
}

fn file() -> PathBuf {
    repository().join("xtask/campaigns.txt")
}

fn read() -> anyhow::Result<BTreeMap<String, String>> {
    let text = match fs::read_to_string(file()) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
        text => text.with_context(|| file().display().to_string())?,
    };
    Ok(parse(&text))
}

/// Names and hashes, a line each.
pub fn parse(text: &str) -> BTreeMap<String, String> {
    let words = text.lines().filter_map(|line| line.split_once(' '));
    words
        .map(|(name, hash)| (name.into(), hash.into()))
        .collect()
}

/// What [`parse`] reads.
pub fn text(record: &BTreeMap<String, String>) -> String {
    let lines = record.iter().map(|(name, hash)| format!("{name} {hash}\n"));
    lines.collect()
}

/// Hash of the names and contents of all files of a part, committed or not, that git does not ignore.
pub fn hash(part: &[&str]) -> anyhow::Result<String> {
    let listing = [
        "ls-files",
        "--cached",
        "--others",
        "--exclude-standard",
        "--",
    ];
    let mut names: Vec<String> = git(&[&listing, part].concat(), "")?
        .lines()
        .filter(|name| repository().join(name).is_file())
        .map(str::to_owned)
        .collect();
    names.sort();
    let names = names.join("\n") + "\n";
    let contents = contents_of(&names)?;
    Ok(git(&["hash-object", "--stdin"], &(names + &contents))?
        .trim()
        .to_owned())
}

/// Hashes of the contents of files, a line each.
pub fn contents(files: &[&Path]) -> anyhow::Result<String> {
    let names = files.iter().map(|file| format!("{}\n", file.display()));
    contents_of(&names.collect::<String>())
}

fn contents_of(names: &str) -> anyhow::Result<String> {
    git(&["hash-object", "--no-filters", "--stdin-paths"], names)
}

fn git(arguments: &[&str], input: &str) -> anyhow::Result<String> {
    let mut child = Command::new("git")
        .args(arguments)
        .current_dir(repository())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .context("git")?;
    let mut stdin = child.stdin.take().context("no input of git")?;
    // Beside reading, so that neither waits for the other.
    let input = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output()?;
    let written = writer.join();
    if !output.status.success() || !matches!(written, Ok(Ok(()))) {
        bail!("git {} failed", arguments.join(" "));
    }
    Ok(String::from_utf8(output.stdout)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_hashes_of_their_own() {
        let core = hash(&["core"]).unwrap();
        assert_eq!(core, hash(&["core"]).unwrap());
        assert_ne!(core, hash(&["core", "tables"]).unwrap());
        assert_eq!(core.len(), 40);
        assert!(!is_current("a campaign that never ran", &["core"]));
    }
}
