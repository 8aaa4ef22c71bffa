//! Expected output beside each program, and the difference to what came.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use console::style;
use similar::{ChangeTag, TextDiff};

/// How a program's lines are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compare {
    /// Every character counts.
    Exact,
    /// Numbers may differ by a little, by more when another compiler made them.
    Figures,
}

/// Counts repeat to the tick from run to run. This lets a change elsewhere in the program move a
/// loop's alignment or a spill without a new snapshot, and no more.
const SAME_COMPILER: f64 = 0.02;
/// Between two compiler versions the same source was seen to differ by several per cent.
const OTHER_COMPILER: f64 = 0.15;

/// Snapshot of a program: for this board alone if there is such a file, else for all.
pub fn path(folder: &Path, program: &str, board: &str) -> PathBuf {
    let shared = folder.join(format!("{program}.out"));
    if shared.exists() {
        shared
    } else {
        folder.join(format!("{program}.{board}.out"))
    }
}

/// Compares `lines` with the snapshot, or writes it when `bless` is set. A difference is printed
/// and is an error.
pub fn check(path: &Path, lines: &[String], compare: Compare, bless: bool) -> anyhow::Result<()> {
    let actual = lines.join("\n") + "\n";
    let expected = match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        other => other.with_context(|| format!("reading {}", path.display()))?,
    };
    if agree(&expected, &actual, compare) {
        return Ok(());
    }
    if bless {
        println!("writing {}", path.display());
        return fs::write(path, actual).with_context(|| format!("writing {}", path.display()));
    }
    print_difference(&expected, &actual);
    bail!(
        "the output differs from {} (if that is right: --bless)",
        path.display()
    )
}

fn agree(expected: &str, actual: &str, compare: Compare) -> bool {
    if compare == Compare::Exact || expected.lines().count() != actual.lines().count() {
        return expected == actual;
    }
    // The first line names the compiler.
    let same_compiler = expected.lines().next() == actual.lines().next();
    let tolerance = if same_compiler {
        SAME_COMPILER
    } else {
        OTHER_COMPILER
    };
    let mut lines = expected.lines().zip(actual.lines()).skip(1);
    lines.all(|(expected, actual)| {
        expected.split_whitespace().count() == actual.split_whitespace().count()
            && (expected.split_whitespace().zip(actual.split_whitespace()))
                .all(|(expected, actual)| words_agree(expected, actual, tolerance))
    })
}

fn words_agree(expected: &str, actual: &str, tolerance: f64) -> bool {
    match (expected.parse::<f64>(), actual.parse::<f64>()) {
        (Ok(expected), Ok(actual)) => (actual - expected).abs() <= tolerance * expected.abs(),
        _ => expected == actual,
    }
}

fn print_difference(expected: &str, actual: &str) {
    let diff = TextDiff::from_lines(expected, actual);
    for group in diff.grouped_ops(2) {
        for change in group.iter().flat_map(|op| diff.iter_changes(op)) {
            let line = change.value().trim_end();
            match change.tag() {
                ChangeTag::Delete => println!("  {}", style(format!("- {line}")).red()),
                ChangeTag::Insert => println!("  {}", style(format!("+ {line}")).green()),
                ChangeTag::Equal => println!("    {line}"),
            }
        }
        println!();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_may_move_a_little_words_may_not() {
        let expected = "rustc 1\ngray8 nearest 10.00\n";
        assert!(agree(
            expected,
            "rustc 1\ngray8 nearest  10.19\n",
            Compare::Figures
        ));
        assert!(!agree(
            expected,
            "rustc 1\ngray8 nearest 10.21\n",
            Compare::Figures
        ));
        assert!(agree(
            expected,
            "rustc 2\ngray8 nearest 11.49\n",
            Compare::Figures
        ));
        assert!(!agree(
            expected,
            "rustc 2\ngray8 nearest 11.51\n",
            Compare::Figures
        ));
        assert!(!agree(
            expected,
            "rustc 1\nrgb8 nearest 10.00\n",
            Compare::Figures
        ));
        assert!(!agree(
            expected,
            "rustc 1\ngray8 nearest\n",
            Compare::Figures
        ));
        assert!(!agree(
            expected,
            "rustc 1\ngray8 nearest  10.00\n",
            Compare::Exact
        ));
    }

    #[test]
    fn a_blessed_snapshot_is_met() {
        let folder = tempfile::tempdir().unwrap();
        let file = path(folder.path(), "stitch", "m7");
        let lines = ["one".to_string(), "two".to_string()];
        assert!(check(&file, &lines, Compare::Exact, false).is_err());
        check(&file, &lines, Compare::Exact, true).unwrap();
        check(&file, &lines, Compare::Exact, false).unwrap();
        assert_eq!(fs::read_to_string(file).unwrap(), "one\ntwo\n");
    }
}
