//! Reading files that may have no end.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Most bytes that are read of a device or a pipe, which do not say how long they are.
const MAX_STREAM_BYTES: u64 = 256 << 20;

/// Reads a whole file of at most `max_bytes`.
///
/// # Errors
/// As reading does; [`io::ErrorKind::FileTooLarge`] for a longer file, or for a device or a pipe
/// that gives more than 256 MiB, such as `/dev/zero`.
pub fn read_limited(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let found = file.metadata()?;
    let max_bytes = if found.is_file() {
        max_bytes
    } else {
        max_bytes.min(MAX_STREAM_BYTES)
    };
    let mut bytes = Vec::new();
    if found.len() <= max_bytes {
        file.take(max_bytes + 1).read_to_end(&mut bytes)?;
    }
    if found.len().max(bytes.len() as u64) > max_bytes {
        let allowed = match max_bytes >> 20 {
            0 => format!("{} KiB", max_bytes >> 10),
            mib => format!("{mib} MiB"),
        };
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it is longer than {allowed}, which no such file is"),
        ));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_refused_without_reading_it_all() {
        let path = std::env::temp_dir().join(format!("tectum-limited-{}", std::process::id()));
        // Sparse: nothing of it could be read in the time of a test.
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = read_limited(&path, 1 << 20).unwrap_err();
        assert!(
            refused.to_string().contains("longer than 1 MiB"),
            "{refused}"
        );
        std::fs::write(&path, b"short").unwrap();
        assert_eq!(read_limited(&path, 5).unwrap(), b"short");
        assert!(read_limited(&path, 4).is_err());
        std::fs::remove_file(&path).unwrap();
        #[cfg(unix)]
        assert!(read_limited(Path::new("/dev/zero"), 1 << 20).is_err());
    }
}
