//! Exposure, gain and white balance, the same on both eyes.

use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::{fmt, io};

use v4l::control::Value;
use v4l::{Control, Device};

use super::{Camera, failure};
use crate::CaptureError;

/// Identifiers of <linux/v4l2-controls.h>.
const AUTO_WHITE_BALANCE: u32 = 0x0098_090c;
const AUTO_GAIN: u32 = 0x0098_0912;
const GAIN: u32 = 0x0098_0913;
const WHITE_BALANCE_K: u32 = 0x0098_091a;
const AUTO_EXPOSURE: u32 = 0x009a_0901;
const EXPOSURE: u32 = 0x009a_0902;
/// `V4L2_CID_EXPOSURE_AUTO_PRIORITY`, which UVC cameras call `exposure_dynamic_framerate`: whether
/// the automatic may lower the frame rate in the dark.
const DYNAMIC_FRAME_RATE: u32 = 0x009a_0903;
/// `V4L2_EXPOSURE_MANUAL`.
const MANUAL_EXPOSURE: i64 = 1;
/// `V4L2_EXPOSURE_SHUTTER_PRIORITY`: the time is set by hand, the aperture is not.
const EXPOSURE_BEFORE_APERTURE: i64 = 2;

/// Values of controls; `None` leaves one alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ControlSettings {
    /// Exposure time, in 100 microseconds.
    pub exposure: Option<i64>,
    /// Gain, in the driver's own units.
    pub gain: Option<i64>,
    /// White balance, kelvin.
    pub white_balance_k: Option<i64>,
}

impl ControlSettings {
    /// Sets them on a device, with the automatics off, and reads them back: drivers round what they are
    /// given to steps of their own.
    pub(super) fn apply(&self, device: &Device) -> io::Result<Self> {
        if let Some(exposure) = self.exposure {
            set_if_there(device, AUTO_EXPOSURE, Value::Integer(MANUAL_EXPOSURE))?;
            set_if_there(device, DYNAMIC_FRAME_RATE, Value::Boolean(false))?;
            set(device, EXPOSURE, exposure)?;
        }
        if let Some(gain) = self.gain {
            set_if_there(device, AUTO_GAIN, Value::Boolean(false))?;
            set(device, GAIN, gain)?;
        }
        if let Some(kelvin) = self.white_balance_k {
            set_if_there(device, AUTO_WHITE_BALANCE, Value::Boolean(false))?;
            set(device, WHITE_BALANCE_K, kelvin)?;
        }
        let has = Self::of(device);
        Ok(Self {
            exposure: self.exposure.map(|asked| has.exposure.unwrap_or(asked)),
            gain: self.gain.map(|asked| has.gain.unwrap_or(asked)),
            white_balance_k: self
                .white_balance_k
                .map(|asked| has.white_balance_k.unwrap_or(asked)),
        })
    }

    /// What a device has now, of those that it has.
    pub(super) fn of(device: &Device) -> Self {
        let value = |id| match device.control(id) {
            Ok(Control {
                value: Value::Integer(value),
                ..
            }) => Some(value),
            _ => None,
        };
        Self {
            exposure: value(EXPOSURE),
            gain: value(GAIN),
            white_balance_k: value(WHITE_BALANCE_K),
        }
    }

    /// What a device keeps to now: not what its automatics do at this moment.
    fn kept(device: &Device) -> Self {
        let is_on = |id, off: &[Value]| match device.control(id) {
            Ok(Control { value, .. }) => !off.contains(&value),
            Err(_) => false,
        };
        let manual = [MANUAL_EXPOSURE, EXPOSURE_BEFORE_APERTURE].map(Value::Integer);
        let off = [Value::Boolean(false)];
        let has = Self::of(device);
        Self {
            exposure: has.exposure.filter(|_| !is_on(AUTO_EXPOSURE, &manual)),
            gain: has.gain.filter(|_| !is_on(AUTO_GAIN, &off)),
            white_balance_k: (has.white_balance_k).filter(|_| !is_on(AUTO_WHITE_BALANCE, &off)),
        }
    }

    /// For a recording's description.
    pub(super) fn facts(&self) -> serde_json::Value {
        serde_json::json!({
            "exposure_ms": self.exposure.map(|v| v as f64 / 10.0),
            "gain": self.gain,
            "white_balance_k": self.white_balance_k,
        })
    }

    /// Of what devices have, what the first has in those controls that all have.
    pub(super) fn common(present: &[Self]) -> Self {
        let common = |pick: fn(&Self) -> Option<i64>| {
            let all_have = present.iter().all(|has| pick(has).is_some());
            present.first().and_then(pick).filter(|_| all_have)
        };
        Self {
            exposure: common(|has| has.exposure),
            gain: common(|has| has.gain),
            white_balance_k: common(|has| has.white_balance_k),
        }
    }
}

/// What the camera at `path` is set to now, as the [facts](crate::FrameSource::facts) of a camera have it;
/// a control is null while an automatic moves it. `None` where there is no camera.
pub fn control_facts(path: &Path) -> Option<serde_json::Value> {
    let is_there = is_device(path);
    let device = is_there.then(|| Device::with_path(path).ok())??;
    Some(ControlSettings::kept(&device).facts())
}

/// Whether a name is a device's: opening something else may wait for its other end.
pub(super) fn is_device(path: &Path) -> bool {
    let kind = path.metadata().map(|data| data.file_type());
    kind.is_ok_and(|kind| kind.is_char_device())
}

fn set(device: &Device, id: u32, value: i64) -> io::Result<()> {
    let value = Value::Integer(value);
    device.set_control(Control { id, value })
}

/// Many cameras have no automatic to turn off.
fn set_if_there(device: &Device, id: u32, value: Value) -> io::Result<()> {
    match device.control(id) {
        Ok(_) => device.set_control(Control { id, value }),
        Err(_) => Ok(()),
    }
}

impl fmt::Display for ControlSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            self.exposure
                .map(|v| format!("exposure {} ms", v as f64 / 10.0)),
            self.gain.map(|v| format!("gain {v}")),
            self.white_balance_k.map(|v| format!("white balance {v} K")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if parts.is_empty() {
            return f.write_str("none");
        }
        f.write_str(&parts.join(", "))
    }
}

/// What cameras have, in words; once where they agree.
pub(super) fn words(present: &[ControlSettings]) -> String {
    let mut each: Vec<String> = present.iter().map(ControlSettings::to_string).collect();
    each.dedup();
    each.join("; ")
}

/// What came of setting controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Locked {
    /// What all cameras were set to; nothing, where they have no such controls.
    pub asked: ControlSettings,
    /// What each camera has of that, read back from it.
    pub has: Vec<ControlSettings>,
}

impl fmt::Display for Locked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&words(&self.has))?;
        if self.has.iter().any(|has| *has != self.asked) {
            write!(f, " (set was {})", self.asked)?;
        }
        Ok(())
    }
}

/// Gives all of these cameras the same exposure, gain and white balance and turns their automatics
/// off: the `asked` values and, with `the_rest_too`, for the others what the first has at this
/// moment, where all have it; then none may lower its frame rate in the dark either.
///
/// # Errors
/// [`CaptureError::NotOffered`] if an asked value is refused.
pub fn lock_together(
    cameras: &mut [&mut Camera],
    asked: ControlSettings,
    the_rest_too: bool,
) -> Result<Locked, CaptureError> {
    let open = |camera: &&mut Camera| {
        let path: &Path = &camera.path;
        Device::with_path(path).map_err(|e| failure::of(path, "opening its controls", e))
    };
    let devices = cameras.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let present: Vec<_> = devices.iter().map(ControlSettings::of).collect();
    let common = if the_rest_too {
        ControlSettings::common(&present)
    } else {
        ControlSettings::default()
    };
    let settings = ControlSettings {
        exposure: asked.exposure.or(common.exposure),
        gain: asked.gain.or(common.gain),
        white_balance_k: asked.white_balance_k.or(common.white_balance_k),
    };
    let mut all = Vec::new();
    for (device, camera) in devices.iter().zip(cameras) {
        let has = settings
            .apply(device)
            .map_err(|_| CaptureError::NotOffered {
                name: camera.name.clone(),
                wanted: format!("the controls: {settings}"),
                offered: format!("  now: {}\n", ControlSettings::of(device)),
            })?;
        camera.keep_controls(settings, has);
        all.push(has);
    }
    Ok(Locked {
        asked: settings,
        has: all,
    })
}
