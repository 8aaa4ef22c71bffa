//! Exposure, gain and white balance, the same on both eyes.

use std::io;
use std::path::Path;

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
/// `V4L2_EXPOSURE_MANUAL`.
const MANUAL_EXPOSURE: i64 = 1;

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
    /// Sets them on a device, with the automatics off.
    pub(super) fn apply(&self, device: &Device) -> io::Result<()> {
        if let Some(exposure) = self.exposure {
            set_if_there(device, AUTO_EXPOSURE, Value::Integer(MANUAL_EXPOSURE))?;
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
        Ok(())
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

/// Gives both eyes the same exposure, gain and white balance and turns their automatics off: the
/// `asked` values and, with `the_rest_too`, for the others what the left eye has at this moment,
/// where both have it.
///
/// # Errors
/// [`CaptureError::NotOffered`] if an asked value is refused.
pub fn lock_together(
    left: &mut Camera,
    right: &mut Camera,
    asked: ControlSettings,
    the_rest_too: bool,
) -> Result<ControlSettings, CaptureError> {
    let open = |path: &Path| {
        Device::with_path(path).map_err(|e| failure::of(path, "opening its controls", e))
    };
    let devices = [open(&left.path)?, open(&right.path)?];
    let [of_left, of_right] = [&devices[0], &devices[1]].map(ControlSettings::of);
    let both = |pick: fn(&ControlSettings) -> Option<i64>| {
        let of_left = pick(&of_left).filter(|_| the_rest_too && pick(&of_right).is_some());
        pick(&asked).or(of_left)
    };
    let settings = ControlSettings {
        exposure: both(|s| s.exposure),
        gain: both(|s| s.gain),
        white_balance_k: both(|s| s.white_balance_k),
    };
    for (device, camera) in devices.iter().zip([&mut *left, &mut *right]) {
        settings
            .apply(device)
            .map_err(|_| CaptureError::NotOffered {
                name: camera.name.clone(),
                wanted: format!(
                    "exposure {:?}, gain {:?}, white balance {:?}",
                    settings.exposure, settings.gain, settings.white_balance_k
                ),
                offered: format!("  now: {:?}\n", ControlSettings::of(device)),
            })?;
        camera.keep_controls(settings);
    }
    Ok(settings)
}
