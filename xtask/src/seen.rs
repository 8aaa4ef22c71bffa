//! Which test programs have passed in this target folder, so that a run after a small change starts
//! only those that the change can touch.
//!
//! A program has nothing new to say while its executable, the program `tectum` that it may start, and
//! all files of the repository that are not Rust sources are the same to the byte.

use std::collections::BTreeMap;
use std::fs;

use xtask::target_dir;

use crate::programs::Program;
use crate::record;

/// What passed here, and what the programs of this run consist of.
#[derive(Debug, Default)]
pub struct Seen {
    passed: BTreeMap<String, String>,
    now: BTreeMap<String, String>,
}

impl Seen {
    /// Reads what passed before and takes the keys of `programs`. Where git cannot tell, nothing has
    /// passed.
    pub fn new(programs: &[Program]) -> Self {
        let text = fs::read_to_string(file()).unwrap_or_default();
        let mut seen = Self {
            passed: record::parse(&text),
            now: BTreeMap::new(),
        };
        // Pictures, rigs, tables, snapshots, README; the record of campaigns is no test's input.
        let Ok(inputs) = record::hash(&[".", ":!*.rs", ":!xtask/campaigns.txt"]) else {
            return seen;
        };
        // Without the data sets beside the checkout other tests run.
        let data = xtask::repository().join("../shared/data").is_dir();
        let tectum = target_dir("debug").join("tectum");
        let mut files = vec![tectum.as_path()];
        files.extend(programs.iter().map(|program| program.path.as_path()));
        let executables = record::contents(&files).unwrap_or_default();
        let mut executables = executables.lines();
        let tectum = executables.next().unwrap_or_default();
        for (program, executable) in programs.iter().zip(executables) {
            let key = format!("{inputs}-{data}-{tectum}-{executable}");
            seen.now.insert(program.name.clone(), key);
        }
        seen
    }

    /// Whether the program passed as it is.
    pub fn has_passed(&self, name: &str) -> bool {
        let now = self.now.get(name);
        now.is_some() && self.passed.get(name) == now
    }

    /// Notes that a program has passed whole.
    pub fn pass(&mut self, name: &str) {
        if let Some(key) = self.now.get(name) {
            self.passed.insert(name.to_owned(), key.clone());
        }
    }

    /// Writes what passed. A failure costs time in the next run and nothing else.
    pub fn keep(&self) {
        let _ = fs::write(file(), record::text(&self.passed));
    }
}

fn file() -> std::path::PathBuf {
    target_dir("xtask").join("passed.txt")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_has_passed_until_it_changes() {
        let folder = target_dir("xtask");
        fs::create_dir_all(&folder).unwrap();
        let program = Program {
            name: "unit/changes".to_owned(),
            path: folder.join("changes"),
            folder,
        };
        let programs = [program.clone()];
        let look = |bytes: &str| {
            fs::write(&program.path, bytes).unwrap();
            Seen::new(&programs)
        };
        let mut seen = look("a program");
        assert!(!seen.has_passed("unit/changes"));
        seen.pass("unit/changes");
        // What was noted, and the keys of another moment.
        let later = |bytes: &str| Seen {
            passed: seen.passed.clone(),
            now: look(bytes).now,
        };
        // Without `tectum` there are no keys, and nothing has passed.
        let is_built = target_dir("debug").join("tectum").is_file();
        assert_eq!(later("a program").has_passed("unit/changes"), is_built);
        assert!(!later("another").has_passed("unit/changes"));
        assert!(!later("a program").has_passed("unit/other"));
    }
}
