//! Which pictures of two eyes were taken at once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::SessionError;

/// Pictures of two eyes, paired.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pairs {
    /// Indices into the left and the right pictures.
    pub pairs: Vec<[usize; 2]>,
    /// Pictures of either eye that have no partner.
    pub alone: Vec<PathBuf>,
}

/// Pairs pictures of two eyes: those whose names (without ending) are equal, or, if none are, those
/// whose last numbers are equal (`left07.png` and `right007.jpg`). A name or number that several
/// pictures of an eye have pairs none of them.
///
/// # Errors
/// [`SessionError::NoPairs`] if none belong together.
pub fn pair_by_name(left: &[PathBuf], right: &[PathBuf]) -> Result<Pairs, SessionError> {
    let mut pairs = pair_by(left, right, stem);
    if pairs.is_empty() {
        pairs = pair_by(left, right, last_number);
    }
    if pairs.is_empty() {
        let first = |files: &[PathBuf]| files.first().cloned().unwrap_or_default();
        return Err(SessionError::NoPairs {
            left: first(left),
            right: first(right),
        });
    }
    let alone = [left, right]
        .iter()
        .enumerate()
        .flat_map(|(side, files)| {
            let paired = |index| pairs.iter().any(|pair: &[usize; 2]| pair[side] == index);
            let lone = files.iter().enumerate().filter(move |(i, _)| !paired(*i));
            lone.map(|(_, file)| file.clone()).collect::<Vec<_>>()
        })
        .collect();
    Ok(Pairs { pairs, alone })
}

fn pair_by(
    left: &[PathBuf],
    right: &[PathBuf],
    key: fn(&Path) -> Option<String>,
) -> Vec<[usize; 2]> {
    let index = |files: &[PathBuf]| {
        let mut by_key = BTreeMap::<String, Vec<usize>>::new();
        for (index, file) in files.iter().enumerate() {
            if let Some(key) = key(file) {
                by_key.entry(key).or_default().push(index);
            }
        }
        by_key
    };
    let right = index(right);
    let mut pairs: Vec<_> = index(left)
        .iter()
        .filter_map(|(key, left)| match (&left[..], &right.get(key)?[..]) {
            (&[left], &[right]) => Some([left, right]),
            _ => None,
        })
        .collect();
    pairs.sort_unstable();
    pairs
}

fn stem(file: &Path) -> Option<String> {
    Some(file.file_stem()?.to_string_lossy().into_owned())
}

/// The last run of digits in the name, without leading zeros.
fn last_number(file: &Path) -> Option<String> {
    let stem = stem(file)?;
    let upto = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let digits = &stem[..upto];
    let from = digits.rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| {
        at + digits[at..].chars().next().map_or(1, char::len_utf8)
    });
    Some(digits[from..].trim_start_matches('0').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    #[test]
    fn names_pair_before_numbers() {
        let left = paths(&["l/a1.png", "l/b1.png", "l/c.png"]);
        let right = paths(&["r/b1.jpg", "r/d.jpg", "r/a1.png"]);
        let pairs = pair_by_name(&left, &right).unwrap();
        assert_eq!(pairs.pairs, [[0, 2], [1, 0]]);
        assert_eq!(pairs.alone, paths(&["l/c.png", "r/d.jpg"]));
    }

    #[test]
    fn numbers_pair_whatever_their_zeros() {
        let left = paths(&["left01.png", "left02.png", "left10é.png", "left000.png"]);
        let right = paths(&["right2_b.png", "right010.png", "right0.png", "r3.png"]);
        let pairs = pair_by_name(&left, &right).unwrap();
        assert_eq!(pairs.pairs, [[1, 0], [2, 1], [3, 2]]);
        assert_eq!(pairs.alone, paths(&["left01.png", "r3.png"]));
    }

    #[test]
    fn what_is_ambiguous_or_nameless_pairs_nothing() {
        let left = paths(&["a1.png", "b1.png"]);
        let right = paths(&["c1.png"]);
        let message = pair_by_name(&left, &right).unwrap_err().to_string();
        assert!(message.contains("a1.png and c1.png"), "{message}");
        assert!(pair_by_name(&paths(&["x.png"]), &[]).is_err());
    }
}
