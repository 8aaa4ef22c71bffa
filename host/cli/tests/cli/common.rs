//! Running the program in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A small fish: its eyes are 240x240 px.
const RIG: &str = include_str!("../../../../tables/rigs/paper-fish-240.toml");

/// A folder with `rig.toml` in it, where commands run.
pub struct Bench(TempDir);

impl Bench {
    pub fn new() -> Self {
        let bench = Self(TempDir::new().expect("a temporary folder"));
        std::fs::write(bench.path("rig.toml"), RIG).expect("a rig file");
        bench
    }

    /// With `fish.tct` baked too: 160x80 px.
    pub fn with_table() -> Self {
        let bench = Self::new();
        bench.done("bake rig.toml -o fish.tct --size 160x80 --max-error 0.4");
        bench
    }

    /// With `left.png` and `right.png` too.
    pub fn with_pictures() -> Self {
        let bench = Self::with_table();
        bench.done("simulate rig.toml -o . --samples 1");
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs `tectum` with arguments separated by spaces.
    pub fn run(&self, arguments: &str) -> Output {
        self.command(env!("CARGO_BIN_EXE_tectum"))
            .args(arguments.split_whitespace())
            .output()
            .expect("the program starts")
    }

    /// A command that runs in the folder.
    pub fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new(program.as_ref());
        command.current_dir(self.0.path());
        command
    }

    /// Runs what must succeed; what it says on stdout.
    pub fn done(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(
            output.status.success(),
            "{arguments}: {}",
            text(&output.stderr)
        );
        assert!(
            output.stderr.is_empty(),
            "{arguments}: {}",
            text(&output.stderr)
        );
        text(&output.stdout)
    }

    /// Runs what must succeed with `--json`: stdout must be one object, nothing else.
    pub fn json(&self, arguments: &str) -> Value {
        let stdout = self.done(&format!("{arguments} --json"));
        let value: Value = serde_json::from_str(&stdout)
            .unwrap_or_else(|error| panic!("{arguments}: {error}: {stdout}"));
        assert!(value.is_object(), "{arguments}: {stdout}");
        value
    }

    /// Runs what must fail with exit code `code`; what it says on stderr. Nothing may be on
    /// stdout, and the folder's files must stay as they are.
    pub fn refused(&self, code: i32, arguments: &str) -> String {
        let before = self.files();
        let output = self.run(arguments);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert_eq!(text(&output.stdout), "", "{arguments}");
        assert_eq!(stderr.matches("error:").count(), 1, "{arguments}: {stderr}");
        assert!(!stderr.contains("panicked"), "{arguments}: {stderr}");
        assert_eq!(self.files(), before, "{arguments}: files came or went");
        stderr
    }

    /// Names of all files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// Width and height of a picture.
    pub fn picture_size(&self, name: &str) -> (u32, u32) {
        image::image_dimensions(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
