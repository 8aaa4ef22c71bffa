//! What a verb has to say, to a person or to a script.

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

/// Outcome of a verb that ran to its end.
pub struct Report {
    /// For a person.
    pub text: String,
    /// For a script: one object.
    pub json: Value,
    /// The verb did its work, and the answer is no.
    pub failure: Option<String>,
}

impl Report {
    /// A report of success.
    pub fn new(text: String, json: Value) -> Self {
        Self {
            text,
            json,
            failure: None,
        }
    }
}

/// Arguments that contradict one another: exit code 2.
#[derive(Debug)]
pub struct Usage(pub String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}. See `tectum help`", self.0)
    }
}

impl std::error::Error for Usage {}

/// Whether stdout carries what the verb makes (`-o -`).
static STDOUT_IS_OUTPUT: AtomicBool = AtomicBool::new(false);

/// From now on stdout carries what the verb makes: reports and errors under `--json` go to stderr.
pub fn stdout_is_output() {
    STDOUT_IS_OUTPUT.store(true, Ordering::Relaxed);
}

/// Prints a report.
///
/// # Errors
/// Of the stream, as on a full disk. A reader that went away (`| head`) is no error.
pub fn print(report: &Report, json: bool) -> io::Result<()> {
    if json {
        line(&report.json.to_string())
    } else {
        line(report.text.trim_end())
    }
}

/// Prints an error on stderr; under `--json` also as an object on stdout. An object that cannot be
/// printed is passed over: the exit code and stderr say the same.
pub fn print_error(error: &str, json: bool) {
    // Under `-o -` stdout is the output's, and stderr has the words already.
    if json && !STDOUT_IS_OUTPUT.load(Ordering::Relaxed) {
        let _ = line(&json!({ "error": error }).to_string());
    }
    let _ = writeln!(io::stderr(), "error: {error}");
}

fn line(text: &str) -> io::Result<()> {
    let written = if STDOUT_IS_OUTPUT.load(Ordering::Relaxed) {
        writeln!(io::stderr(), "{text}")
    } else {
        let mut stdout = io::stdout();
        writeln!(stdout, "{text}").and_then(|()| stdout.flush())
    };
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// A path for a script; what is not UTF-8 in it is replaced, as in what a person reads.
pub fn path_json(path: impl AsRef<Path>) -> Value {
    Value::from(path.as_ref().display().to_string())
}

/// Paths for a script.
pub fn paths_json(paths: impl IntoIterator<Item = impl AsRef<Path>>) -> Value {
    paths.into_iter().map(path_json).collect()
}

/// The whole chain of an error in one message, without causes that a message already quotes.
pub fn explain(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text.trim_end().to_owned()
}

/// `{max, rms}` in words.
pub fn max_rms(error: &tectum_bake::ErrorSummary, unit: &str) -> String {
    format!("{:.4} {unit} max, {:.4} {unit} RMS", error.max, error.rms)
}
