//! A rig with other poses or other scales of its lenses, as registration finds them.

use super::file::{EyeFile, LensFile, PoseFile, RigFile};
use super::{Rig, RigError, Stitching, StitchingFile, read};
use crate::Pose;

impl Rig {
    /// The rig with its eyes at `poses` (left, right) in the body frame; an eye that the rig does not
    /// have is passed over. Its file then gives poses in the body's own frame: `[mount]` and
    /// `[reference]`, which would contradict them, are gone. `[stitching]` stays.
    ///
    /// # Errors
    /// [`RigError`] if a pose is not allowed, as one beyond the stitch distance.
    pub fn with_poses(&self, poses: [Pose; 2]) -> Result<Self, RigError> {
        self.edited(|file| {
            file.mount = None;
            file.reference = None;
            for (eye, pose) in [&mut file.left, &mut file.right].into_iter().zip(poses) {
                if let Some(eye) = eye {
                    eye.pose = Some(PoseFile::from(&pose));
                }
            }
        })
    }

    /// The rig with its lenses' pictures (left, right) `scales` times as large about their principal
    /// points.
    ///
    /// # Errors
    /// [`RigError`] if a scale is not positive, or leaves an eye blind where it says it sees.
    pub fn with_lens_scales(&self, scales: [f64; 2]) -> Result<Self, RigError> {
        self.edited(|file| {
            let eyes = [&mut file.left, &mut file.right].into_iter().zip(scales);
            for (eye, scale) in eyes {
                if let Some(EyeFile { lens, .. }) = eye {
                    lens.scale(scale);
                }
            }
        })
    }

    /// The rig whose outputs are joined at another distance, m; may be infinite.
    ///
    /// # Errors
    /// [`RigError`] if the distance is not beyond both eyes.
    pub fn with_stitch_distance(&self, distance_m: f64) -> Result<Self, RigError> {
        self.edited(|file| file.stitch_distance_m = distance_m)
    }

    /// The rig with other seam, tone and warp, and the files that hold them.
    #[must_use]
    pub fn with_stitching(&self, stitching: Stitching, named: StitchingFile) -> Self {
        let mut rig = self.clone();
        rig.file.stitching = Some(named);
        rig.stitching = Some(stitching);
        rig
    }

    /// What reading the edited file would give.
    fn edited(&self, edit: impl FnOnce(&mut RigFile)) -> Result<Self, RigError> {
        let mut file = self.file.clone();
        edit(&mut file);
        // The pictures that it names have been read.
        let named = file.stitching.take();
        let mut rig = read::rig(file, &self.name)?;
        rig.file.stitching = named;
        rig.stitching.clone_from(&self.stitching);
        Ok(rig)
    }
}

impl LensFile {
    fn scale(&mut self, by: f64) {
        match self {
            Self::Equidistant {
                focal_px_per_rad, ..
            } => *focal_px_per_rad *= by,
            // s f(rho / s) at s times the radius is the same ray.
            Self::Ocam {
                direct,
                decentring_per_px,
                ..
            } => {
                let mut power = by;
                for a in direct {
                    *a *= power;
                    power /= by;
                }
                *decentring_per_px = decentring_per_px.map(|t| t / by);
            }
            Self::KannalaBrandt { focal_px, .. }
            | Self::DoubleSphere { focal_px, .. }
            | Self::Eucm { focal_px, .. } => *focal_px = focal_px.map(|f| f * by),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::rotation_vector;

    const RIG: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
        [mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n\
        [reference]\naxes = { x = 'forward', y = 'down', z = 'left' }\n\
        [left]\nsize_px = [480, 480]\nfield_deg = 160.0\nlens = LENS\n\
        [right]\nsize_px = [480, 480]\nfield_deg = 160.0\n\
        lens = { model = 'equidistant', focal_px_per_rad = 129.9, centre_px = [239.5, 239.5] }\n";

    fn rig(lens: &str) -> Rig {
        Rig::from_toml(&RIG.replace("LENS", lens), "rig.toml").unwrap()
    }

    const OCAM: &str = "{ model = 'ocam', direct = [-130.0, 0.0, 1e-3, 2e-7], centre_row_column = \
        [238.0, 241.0], affine = [1.001, 1e-3, -2e-3], decentring_per_px = [1e-6, -2e-6] }";

    #[test]
    fn poses_are_written_and_read_equal() {
        let rig = rig(OCAM);
        let turned = [0.3, -2.8].map(|angle| Pose {
            rotation: rotation_vector(&(Vector3::new(0.6, 0.0, 0.8) * angle)),
            position_m: Vector3::new(0.01, angle / 100.0, -0.002),
        });
        let moved = rig.with_poses(turned).unwrap();
        for (eye, pose) in [&moved.left, &moved.right].into_iter().zip(&turned) {
            let eye = eye.as_ref().unwrap();
            // Rounding through a rotation vector and mm.
            let off = eye.pose.rotation.matrix() - pose.rotation.matrix();
            assert!(off.norm() < 1e-14, "{off}");
            assert!((eye.pose.position_m - pose.position_m).norm() < 1e-15);
        }
        let again = Rig::from_toml(&moved.to_toml().unwrap(), "again").unwrap();
        assert_eq!(again, moved);
        assert_ne!(moved.fingerprint(), rig.fingerprint());
        let mut far = turned;
        far[0].position_m.x = 3.0;
        let refused = rig.with_poses(far).unwrap_err().to_string();
        assert!(refused.contains("stitch_distance_m"), "{refused}");
    }

    #[test]
    fn every_lens_is_scaled_about_its_principal_point() {
        let centre = "centre_px = [239.0, 240.5]";
        for lens in [
            OCAM.to_owned(),
            format!("{{ model = 'equidistant', focal_px_per_rad = 130.0, {centre} }}"),
            format!(
                "{{ model = 'kannala_brandt', focal_px = [130.0, 131.0], {centre}, \
                 distortion = [0.01, -0.002, 0.0, 0.0] }}"
            ),
            format!(
                "{{ model = 'double_sphere', focal_px = [130.0, 131.0], {centre}, xi = -0.2, \
                 alpha = 0.6 }}"
            ),
            format!(
                "{{ model = 'eucm', focal_px = [130.0, 131.0], {centre}, alpha = 0.6, beta = 1.1 }}"
            ),
        ] {
            let rig = rig(&lens);
            let scaled = rig.with_lens_scales([1.02, 0.97]).unwrap();
            let again = Rig::from_toml(&scaled.to_toml().unwrap(), "again").unwrap();
            assert_eq!(again, scaled);
            let eyes = [
                (&rig.left, &scaled.left, 1.02),
                (&rig.right, &scaled.right, 0.97),
            ];
            for (before, after, scale) in eyes {
                let [before, after] = [before, after].map(|eye| &eye.as_ref().unwrap().eye.model);
                let ray = Vector3::new(0.5, -0.7, 0.4);
                let centre = before.principal_point_px();
                let [a, b] = [before, after].map(|model| model.project(&ray).unwrap());
                for k in 0..2 {
                    let expected = centre[k] + scale * (a[k] - centre[k]);
                    // A root found to rounding at hundreds of px.
                    assert!((b[k] - expected).abs() < 1e-9, "{lens}: {b:?} {expected}");
                }
            }
        }
        assert!(rig(OCAM).with_lens_scales([0.0, 1.0]).is_err());
    }
}
