//! The eyes that are given, in one of four ways.

use tectum_optics::design::{BothEyes, Mount, sensor_clip};
use tectum_optics::{Field, Medium, Rig};

use super::args::{Args, Range};
use crate::files;
use crate::report::Usage;

/// Eyes that are given.
pub struct Given {
    /// Both fields.
    pub eyes: BothEyes,
    /// The rig they are from.
    pub rig: Option<Rig>,
    /// Whether the fields are those in water already.
    pub wet: bool,
}

impl Given {
    /// From arguments.
    pub fn of(args: &Args) -> anyhow::Result<Self> {
        if let Some(path) = &args.rig {
            let rig = files::rig(path)?;
            return Ok(Self {
                eyes: BothEyes::of_rig(&rig)?,
                wet: rig.calibrated_in == Medium::Water,
                rig: Some(rig),
            });
        }
        let mount = mount(args)?.ok_or_else(|| {
            Usage(
                "a mount is needed: --psi and --tau, --normal, or --rig; or a wish: --want".into(),
            )
        })?;
        let (field, wet) = field(args)?;
        Ok(Self {
            eyes: BothEyes::of_mount(&mount, &field),
            rig: None,
            wet,
        })
    }
}

/// The mount that is given; `None` if an angle is missing.
pub fn mount(args: &Args) -> anyhow::Result<Option<Mount>> {
    if let Some(normal) = &args.normal {
        return Ok(Some(Mount::from_normal(&normal.0)?));
    }
    let (Some(psi), Some(tau)) = (args.psi, args.tau) else {
        return Ok(None);
    };
    let [psi, tau] = [single("--psi", psi)?, single("--tau", tau)?];
    Ok(Some(Mount::new(psi.to_radians(), tau.to_radians())?))
}

fn field(args: &Args) -> anyhow::Result<(Field, bool)> {
    if let Some(path) = &args.eye {
        let eye = files::eye(path)?;
        let field = tectum_optics::design::shown_field(&eye.eye);
        return Ok((field, eye.medium == Medium::Water));
    }
    let theta = args
        .theta
        .ok_or_else(|| Usage("a lens is needed: --theta, --eye or --rig".into()))?;
    let half_rad = single("--theta", theta)?.to_radians() / 2.0;
    // As wide as high: a circle that nothing clips.
    let [width, height] = args.sensor.map_or([1.0, 1.0], |sensor| sensor.0);
    Ok((sensor_clip(half_rad, width, height)?, false))
}

fn single(name: &str, range: Range) -> Result<f64, Usage> {
    range.single().ok_or_else(|| {
        Usage(format!(
            "{name} {}..{} is a range: it goes with a wish, --want or --best",
            range.low, range.high
        ))
    })
}
