//! The system's errors in words.

use std::io;
use std::path::Path;

use crate::CaptureError;

/// Numbers of <errno.h>, the same on every Linux that has Video4Linux.
const ENXIO: i32 = 6;
const EACCES: i32 = 13;
const EBUSY: i32 = 16;
const ENODEV: i32 = 19;
const EINVAL: i32 = 22;
const ENOTTY: i32 = 25;
const ENOSPC: i32 = 28;

/// What `error` means when it came while `doing` something with the device at `path`.
pub(super) fn of(path: &Path, doing: &'static str, error: io::Error) -> CaptureError {
    let name = path.display().to_string();
    match error.raw_os_error() {
        Some(ENXIO | ENODEV) => CaptureError::NoDevice(name),
        Some(EACCES) => CaptureError::NoPermission(name),
        Some(EBUSY) => CaptureError::Busy(name),
        Some(ENOTTY) => not_capture(path, "it does not speak Video4Linux"),
        // A USB bus without room for both cameras' data.
        Some(ENOSPC) => CaptureError::Driver {
            name,
            doing: "starting (the USB bus has no room for what this camera would send: put it on \
                    another port, one of another controller, or give a smaller --frame-size, a \
                    lower --rate or --pixel-format MJPG)",
            source: error,
        },
        Some(EINVAL) if doing == "asking what it is" => {
            not_capture(path, "it does not speak Video4Linux")
        }
        _ if error.kind() == io::ErrorKind::NotFound => CaptureError::NoDevice(name),
        _ => CaptureError::Driver {
            name,
            doing,
            source: error,
        },
    }
}

/// Whether the driver does not know what it was asked for.
pub(super) fn is_unknown_request(error: &io::Error) -> bool {
    error.raw_os_error() == Some(ENOTTY)
}

/// The device at `path` is something else.
pub(super) fn not_capture(path: &Path, why: &str) -> CaptureError {
    CaptureError::NotCapture {
        name: path.display().to_string(),
        why: why.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_says_what_to_do() {
        for (number, parts) in [
            (ENODEV, ["no such camera", "--list"]),
            (EACCES, ["no permission", "usermod"]),
            (EBUSY, ["busy", "Close"]),
            (ENOTTY, ["not a camera", "--list"]),
            (ENOSPC, ["USB", "MJPG"]),
        ] {
            let error = of(
                Path::new("/dev/video7"),
                "starting",
                io::Error::from_raw_os_error(number),
            );
            let text = error.to_string();
            for part in parts.iter().chain(&["/dev/video7"]) {
                assert!(text.contains(part), "no {part:?} in {text:?}");
            }
        }
    }

    #[test]
    fn files_and_other_devices_are_no_cameras() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("picture.png");
        std::fs::write(&file, b"x").unwrap();
        for path in [&*file, Path::new("/dev/null")] {
            let error = super::super::Camera::open(path, super::super::Wanted::default());
            let error = error.unwrap_err();
            assert!(matches!(error, CaptureError::NotCapture { .. }), "{error}");
        }
        let error = super::super::Camera::open(
            Path::new("/dev/v4l/by-id/none"),
            super::super::Wanted::default(),
        );
        assert!(matches!(error, Err(CaptureError::NoDevice(_))));
    }
}
