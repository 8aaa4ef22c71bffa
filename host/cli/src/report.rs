//! What a verb has to say, to a person or to a script.

use std::io::Write;

use serde_json::Value;

/// Outcome of a verb that ran to its end.
pub struct Report {
    /// For a person.
    pub text: String,
    /// For a script: one object.
    pub json: Value,
    /// The verb did its work, and the answer is no.
    pub failure: Option<String>,
    /// Stdout carries what the verb made: the report goes to stderr.
    pub beside_output: bool,
}

impl Report {
    /// A report of success.
    pub fn new(text: String, json: Value) -> Self {
        Self {
            text,
            json,
            failure: None,
            beside_output: false,
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

/// Prints a report, on stdout as a rule. A reader that went away (`| head`) is no error.
pub fn print(report: &Report, json: bool) {
    let text = if json {
        report.json.to_string()
    } else {
        report.text.trim_end().to_owned()
    };
    let _ = if report.beside_output {
        writeln!(std::io::stderr(), "{text}")
    } else {
        writeln!(std::io::stdout(), "{text}")
    };
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
