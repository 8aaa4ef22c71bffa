//! Exposure, gain and white balance while the cameras run, as the preview's page sets them.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

use v4l::Device;

use super::ControlSettings;
use super::controls::{is_device, words};
use crate::Health;
use crate::preview::{Controls, Eyes, Outcome, lock};

/// Greatest exposure time that is asked of a camera, in 0.1 ms.
const MAX_EXPOSURE: i64 = 100_000;
/// Whether a camera has come back is looked at this often.
const LOOK: Duration = Duration::from_secs(1);

/// Controls of one or two cameras while they run. What the page sets is set again when a camera
/// comes back.
pub struct LiveControls(Arc<Inner>);

struct Inner {
    cameras: Vec<(PathBuf, Arc<Health>)>,
    kept: Mutex<ControlSettings>,
    /// What the cameras have, in words: the page asks often, and asking a camera takes its time.
    text: Mutex<String>,
}

impl std::fmt::Debug for LiveControls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LiveControls").finish_non_exhaustive()
    }
}

impl LiveControls {
    /// Of eyes that are cameras, by their names; `None` if an eye is no camera, or if no camera has
    /// a control that can be set.
    pub fn of(eyes: &Eyes) -> Option<Self> {
        let eyes = eyes.iter().flatten();
        let cameras: Vec<_> = eyes
            .map(|(name, health)| (PathBuf::from(name), health.clone()))
            .collect();
        if cameras.is_empty() || !cameras.iter().all(|(path, _)| is_device(path)) {
            return None;
        }
        let inner = Arc::new(Inner {
            cameras,
            kept: Mutex::default(),
            text: Mutex::default(),
        });
        let has_any = |settings: &ControlSettings| *settings != ControlSettings::default();
        if !inner.present().ok()?.iter().any(has_any) {
            return None;
        }
        inner.refresh();
        let watched = Arc::downgrade(&inner);
        let thread = std::thread::Builder::new().name("controls".to_owned());
        thread.spawn(move || set_again(&watched)).ok()?;
        Some(Self(inner))
    }
}

impl Controls for LiveControls {
    fn text(&self) -> String {
        lock(&self.0.text).clone()
    }

    fn set_exposure(&self, exposure: i64) -> Outcome {
        if !(1..=MAX_EXPOSURE).contains(&exposure) {
            return Err(format!(
                "needed is an exposure time of 1 to {MAX_EXPOSURE}, in 0.1 ms"
            ));
        }
        // Not within the call below: it locks what is kept as well.
        let kept = *lock(&self.0.kept);
        self.0.set(ControlSettings {
            exposure: Some(exposure),
            ..kept
        })
    }

    fn lock(&self) -> Outcome {
        let present = self.0.present()?;
        self.0.set(ControlSettings::common(&present))
    }
}

impl Inner {
    /// What each camera has now.
    fn present(&self) -> Result<Vec<ControlSettings>, String> {
        let cameras = self.cameras.iter();
        cameras
            .map(|(path, _)| Ok(ControlSettings::of(&open(path)?)))
            .collect()
    }

    /// Sets all cameras, or none: where one refuses, those before it get back what they had.
    fn set(&self, settings: ControlSettings) -> Outcome {
        let before = self.present()?;
        for (k, (path, _)) in self.cameras.iter().enumerate() {
            if let Err(reason) = apply(path, &settings) {
                for ((path, _), had) in self.cameras[..k].iter().zip(&before) {
                    // What it refuses now is in the text on the page.
                    let _ = apply(path, had);
                }
                self.refresh();
                return Err(reason);
            }
        }
        *lock(&self.kept) = settings;
        self.refresh();
        Ok(format!("set: {}", lock(&self.text)))
    }

    fn refresh(&self) {
        let words = match self.present() {
            Ok(present) => words(&present),
            Err(reason) => reason,
        };
        *lock(&self.text) = words;
    }
}

/// Gives cameras that came back what the page set, as long as there are controls.
fn set_again(controls: &Weak<Inner>) {
    let mut times: Option<Vec<u64>> = None;
    while let Some(inner) = controls.upgrade() {
        let cameras = inner.cameras.iter();
        let now = cameras.map(|(_, health)| health.counts().reconnects);
        let now: Vec<u64> = now.collect();
        if times.as_ref().is_some_and(|before| *before != now) {
            let kept = *lock(&inner.kept);
            for (path, _) in &inner.cameras {
                // One that is away again comes back again.
                let _ = apply(path, &kept);
            }
            inner.refresh();
        }
        times = Some(now);
        drop(inner);
        std::thread::sleep(LOOK);
    }
}

fn open(path: &Path) -> Result<Device, String> {
    Device::with_path(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn apply(path: &Path, settings: &ControlSettings) -> Result<(), String> {
    let done = settings.apply(&open(path)?);
    done.map(drop)
        .map_err(|error| format!("{}: the camera refuses this: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_camera_has_no_controls() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("left.y4m");
        std::fs::write(&file, b"x").unwrap();
        for path in [&*file, Path::new("/dev/null"), Path::new("/dev/video999")] {
            let eye = Some((path.display().to_string(), Arc::default()));
            assert!(LiveControls::of(&[eye, None]).is_none(), "{path:?}");
        }
        assert!(LiveControls::of(&[None, None]).is_none());
    }

    #[test]
    fn cameras_that_agree_are_told_once() {
        let has = |exposure| ControlSettings {
            exposure: Some(exposure),
            gain: Some(4),
            white_balance_k: None,
        };
        assert_eq!(words(&[has(57), has(57)]), "exposure 5.7 ms, gain 4");
        let differ = "exposure 5.7 ms, gain 4; exposure 6 ms, gain 4";
        assert_eq!(words(&[has(57), has(60)]), differ);
    }
}
