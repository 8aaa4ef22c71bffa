//! Time and sequence of a frame as text, inside recordings.

/// `TS=123456 SEQ=7`: ns and count.
pub(crate) fn write(time_ns: i64, sequence: u32) -> String {
    format!("TS={time_ns} SEQ={sequence}")
}

/// Reads what [`write()`] wrote, wherever it stands among other words; `None` if it is not there.
pub(crate) fn read(text: &[u8]) -> Option<(i64, u32)> {
    let text = std::str::from_utf8(text).ok()?;
    let word = |key: &str| {
        text.split_ascii_whitespace()
            .find_map(|word| word.trim_start_matches('X').strip_prefix(key))
    };
    Some((word("TS=")?.parse().ok()?, word("SEQ=")?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_written_is_read() {
        for (time, sequence) in [(0, 0), (i64::MIN, u32::MAX), (1_234_567_890, 7)] {
            let text = super::write(time, sequence);
            assert_eq!(super::read(text.as_bytes()), Some((time, sequence)));
        }
        assert_eq!(super::read(b"Ip XTS=5 XSEQ=6\n"), Some((5, 6)));
        assert_eq!(super::read(b"TS=five SEQ=6"), None);
        assert_eq!(super::read(&[0xff, 0xfe]), None);
    }
}
