//! The test programs: built once, then listed from what cargo says of them.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use serde_json::Value;
use xtask::repository;

use crate::cargo::{cargo, everything, text};

/// A test program that has been built.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// Folder of the package and name of the target: `host/bake/lookup`, `core/lib`.
    pub name: String,
    /// The executable.
    pub path: PathBuf,
    /// Folder of its package, where cargo starts it too.
    pub folder: PathBuf,
}

impl Program {
    /// Starts it as cargo does.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command
            .current_dir(&self.folder)
            .env("CARGO_MANIFEST_DIR", &self.folder);
        command
    }
}

/// Builds the programs that tests and checks start, libraries and tests of the workspace; the test
/// programs in the order of their names.
pub fn build() -> anyhow::Result<Vec<Program>> {
    let mut command = cargo(&[
        "build",
        "--bin",
        "tectum",
        "--bin",
        "tectum-checks",
        "--tests",
    ]);
    command
        .args(everything())
        .arg("--message-format=json-render-diagnostics")
        .stdout(Stdio::piped());
    let mut child = command.spawn().with_context(|| text(&command))?;
    let stdout = child.stdout.take().context("no output of cargo")?;
    let mut programs = Vec::new();
    for line in BufReader::new(stdout).lines() {
        programs.extend(program(&line?));
    }
    if !child.wait()?.success() {
        bail!("failed: {}", text(&command));
    }
    programs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(programs)
}

/// The test program that a message of cargo tells of, if it does.
fn program(message: &str) -> Option<Program> {
    let message: Value = serde_json::from_str(message).ok()?;
    let path = PathBuf::from(message["executable"].as_str()?);
    if message["profile"]["test"] != true {
        return None;
    }
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    let target = &message["target"];
    let name = match target["kind"][0].as_str()? {
        "lib" => "lib",
        _ => target["name"].as_str()?,
    };
    let package = folder.strip_prefix(repository()).unwrap_or(folder);
    Some(Program {
        name: package.join(name).display().to_string(),
        path,
        folder: folder.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_test_programs_are_listed() {
        let manifest = repository().join("host/bake/Cargo.toml");
        let manifest = manifest.display();
        let message = |kind, test, executable| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"{manifest}","target":{{"kind":["{kind}"],"name":"lookup"}},"profile":{{"test":{test}}},"executable":{executable}}}"#
            )
        };
        let built = program(&message("test", true, r#""/t/lookup-1""#)).unwrap();
        assert_eq!(built.name, "host/bake/lookup");
        assert_eq!(built.path, Path::new("/t/lookup-1"));
        let unit = program(&message("lib", true, r#""/t/bake-1""#)).unwrap();
        assert_eq!(unit.name, "host/bake/lib");
        assert_eq!(program(&message("bin", false, r#""/t/x""#)), None);
        assert_eq!(program(&message("lib", false, "null")), None);
        assert_eq!(program("no json"), None);
    }
}
