//! Room on the disk.

use std::path::Path;

use crate::CaptureError;

/// Recordings stop when less is free: a full disk stops more than a recording.
pub const MIN_FREE_BYTES: u64 = 200 << 20;

/// Free bytes of the disk that holds `path` (a file yet to be made, or a folder), for this user.
///
/// # Errors
/// [`CaptureError::Io`] if the disk cannot be asked.
pub fn free_bytes(path: &Path) -> Result<u64, CaptureError> {
    let place = path
        .ancestors()
        .map(|place| {
            if place.as_os_str().is_empty() {
                Path::new(".")
            } else {
                place
            }
        })
        .find(|place| place.exists())
        .unwrap_or(Path::new("."));
    let disk = rustix::fs::statvfs(place).map_err(|error| CaptureError::io(path, error.into()))?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Refuses when the disk that holds `path` has less than `needed_bytes` free.
///
/// # Errors
/// [`CaptureError::DiskFull`]; [`CaptureError::Io`] if the disk cannot be asked.
pub fn check_free(path: &Path, needed_bytes: u64) -> Result<(), CaptureError> {
    let free = free_bytes(path)?;
    if free < needed_bytes {
        return Err(CaptureError::DiskFull {
            path: path.to_owned(),
            free_mb: free >> 20,
            needed_mb: needed_bytes >> 20,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_without_room_is_refused_and_one_with_room_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("not/yet/made.y4m");
        check_free(&file, 1).unwrap();
        let error = check_free(&file, u64::MAX).unwrap_err();
        assert!(matches!(error, CaptureError::DiskFull { .. }), "{error}");
        assert!(error.to_string().contains("made.y4m"), "{error}");
    }
}
