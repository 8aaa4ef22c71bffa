use std::path::PathBuf;

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::*;
use crate::camera::{CameraModel, DoubleSphere, KannalaBrandt};
use crate::io::opencv::{FileStorage, FisheyeCalib};
use crate::io::{RelativePose, kalibr};
use crate::{Pose, rotation_vector};

/// Eyes at yaw 50 and -50 degrees, tilted up by 20, nearly level, 72 mm apart.
fn truth() -> [Pose; 2] {
    let yaw = 50f64.to_radians();
    let up = -20f64.to_radians();
    let odd = rotation_vector(&Vector3::new(0.01, -0.004, 0.006));
    [(1.0, odd), (-1.0, odd.inverse())].map(|(side, odd)| Pose {
        rotation: odd * Pose::axis_rotation(side * yaw, up, 0.0),
        position_m: Vector3::new(0.0, side * 0.036, 0.0),
    })
}

/// Left camera, right camera.
fn models() -> [KannalaBrandt; 2] {
    let lens = |f: f64| KannalaBrandt::new([f, f], [479.5, 359.5], [-0.01, 0.002, 0.0, 0.0]);
    [lens(300.0).unwrap(), lens(303.0).unwrap()]
}

fn camera(model: &KannalaBrandt) -> CalibratedCamera {
    CalibratedCamera {
        model: CameraModel::KannalaBrandt(*model),
        size_px: [960, 720],
    }
}

/// From `poses[first]` to the other's frame.
fn relative(poses: &[Pose; 2], first: usize) -> RelativePose {
    let (a, b) = (&poses[first], &poses[1 - first]);
    let into_a = a.rotation.inverse();
    RelativePose::of_second(
        &(into_a * b.rotation),
        &(into_a * (b.position_m - a.position_m)),
    )
}

fn load(text: &str) -> Result<Rig, String> {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("anything.toml");
    std::fs::write(&path, text).unwrap();
    Rig::load(&path).map_err(|error| error.to_string())
}

/// The eyes are where they were: to each other to rounding, and in the body to what a symmetric mount
/// cannot tell, which is nothing here.
fn check(rig: &Rig, focal_px: [f64; 2]) {
    let truth = truth();
    let [left, right] = [&rig.left, &rig.right].map(|eye| eye.as_ref().unwrap());
    let found = [left.pose, right.pose];
    let [a, b] = [relative(&found, 0), relative(&truth, 0)];
    let turn = a.rotation.matrix() - b.rotation.matrix();
    assert!(turn.norm() < 1e-9, "{turn}");
    assert!((a.translation_m - b.translation_m).norm() < 1e-9);
    for (found, truth) in found.iter().zip(&truth) {
        // Half of what is odd about both, about the axis that a mount leaves open.
        let off = angle_of(&(found.rotation.inverse() * truth.rotation));
        assert!(off < 0.02, "{off}");
        assert!((found.position_m - truth.position_m).norm() < 1e-3);
    }
    for (eye, focal) in [left, right].into_iter().zip(focal_px) {
        let CameraModel::KannalaBrandt(lens) = &eye.eye.model else {
            panic!("{:?}", eye.eye.model);
        };
        assert_eq!(lens.focal_px, [focal; 2]);
        // 479.5 px at the left and right sides.
        let edge = eye.eye.model.unproject([0.0, 359.5]).unwrap();
        let half = angle_between(&edge, &Vector3::z());
        assert!((eye.eye.field.widest_rad() - half).abs() < 1e-9);
    }
    assert_eq!(
        (rig.medium, rig.stitch_distance_m),
        (Medium::Air, f64::INFINITY)
    );
    // Written as a rig it stays the same.
    let again = Rig::from_toml(&rig.to_toml().unwrap(), "again").unwrap();
    assert_eq!((&again.left, &again.right), (&rig.left, &rig.right));
}

fn angle_of(rotation: &Rotation3<f64>) -> f64 {
    crate::vector_of_rotation(rotation).norm()
}

#[test]
fn a_chain_of_kalibr_is_the_rig_it_was_written_from() {
    let [left, right] = models();
    for (first, told) in [
        (0, "the first camera is the left eye"),
        (1, "the second camera is the left eye"),
    ] {
        let cameras = match first {
            0 => [&left, &right],
            _ => [&right, &left],
        };
        let chain = CameraChain {
            cameras: cameras.map(camera).into(),
            second_from_first: Some(Ok(relative(&truth(), first))),
        };
        let text = kalibr::to_text(&chain).unwrap();
        assert!(text.contains("T_cn_cnm1"), "{text}");
        assert_eq!(kalibr::parse(&text).unwrap(), chain);
        let rig = load(&text).unwrap();
        check(&rig, [300.0, 303.0]);
        let assumed = rig.remarks().join("\n");
        for part in [told, "72.00 mm", "Kalibr", "air", "infinity"] {
            assert!(assumed.contains(part), "{part}: {assumed}");
        }
        assert_eq!(rig.name, "anything");
    }
}

#[test]
fn what_a_chain_says_of_a_point_the_rig_says_too() {
    // Direction: a point of camera 0's frame goes through T_cn_cnm1 into camera 1's.
    let pose = relative(&truth(), 0);
    let chain = CameraChain {
        cameras: models().each_ref().map(camera).into(),
        second_from_first: Some(Ok(pose)),
    };
    let rig = load(&kalibr::to_text(&chain).unwrap()).unwrap();
    let [left, right] = [&rig.left, &rig.right].map(|eye| eye.as_ref().unwrap());
    let in_first = Vector3::new(0.9, 0.1, 1.0);
    let in_second = pose.rotation * in_first + pose.translation_m;
    let body = left.pose.rotation * in_first + left.pose.position_m;
    let pixel = right.pixel_of(&body.normalize(), body.norm()).unwrap();
    let expected = camera(&models()[1]).model.project(&in_second).unwrap();
    // Rounding at hundreds of px.
    assert!((pixel[0] - expected[0]).abs() < 1e-9 && (pixel[1] - expected[1]).abs() < 1e-9);
}

#[test]
fn a_stereo_calibration_of_opencv_is_a_rig() {
    let [left, right] = models();
    let storage = FileStorage::of_stereo([&left, &right], [960, 720], &relative(&truth(), 0));
    let rig = load(&storage.to_text()).unwrap();
    check(&rig, [300.0, 303.0]);
    let alone = storage.to_text().replace("R:", "E:").replace("T:", "F:");
    let refused = load(&alone).unwrap_err();
    assert!(refused.contains("no pose between"), "{refused}");
}

#[test]
fn a_calibration_of_basalt_is_a_rig() {
    // The IMU is somewhere else, and turned.
    let imu = rotation_vector(&Vector3::new(-0.4, 0.3, 1.2));
    let poses = truth().map(|pose| {
        let q = UnitQuaternion::from_rotation_matrix(&(imu * pose.rotation));
        let p = imu * pose.position_m + Vector3::new(0.1, -0.2, 0.05);
        format!(
            "{{\"px\": {:?}, \"py\": {:?}, \"pz\": {:?}, \"qx\": {:?}, \"qy\": {:?}, \"qz\": {:?}, \
             \"qw\": {:?}}}",
            p.x, p.y, p.z, q.i, q.j, q.k, q.w
        )
    });
    let cameras: Vec<_> = models().iter().map(camera).collect();
    let text = crate::io::basalt::to_text(&cameras).unwrap();
    let with_poses = format!("\"value0\": {{\"T_imu_cam\": [{}, {}],", poses[0], poses[1]);
    let text = text.replacen("\"value0\": {", &with_poses, 1);
    check(&load(&text).unwrap(), [300.0, 303.0]);
    let long = text.replacen("\"qw\": ", "\"qw\": 9", 1);
    let refused = load(&long).unwrap_err();
    assert!(refused.contains("T_imu_cam[0]"), "{refused}");
}

#[test]
fn one_camera_is_an_eye_and_two_are_a_rig() {
    let calib = FisheyeCalib {
        model: models()[0],
        size_px: Some([960, 720]),
    };
    let one = FileStorage::from(&calib).to_text();
    let refused = load(&one).unwrap_err();
    assert!(refused.contains("one camera, an eye"), "{refused}");
    let eye = calibrated_eye(Format::OpenCv, &one, "eye.yml").unwrap();
    assert_eq!(eye.medium, Medium::Air);
    assert!(eye.remarks[0].contains("eye.yml"), "{:?}", eye.remarks);
    let storage = FileStorage::of_stereo(
        [&models()[0], &models()[1]],
        [960, 720],
        &relative(&truth(), 0),
    );
    let both = storage.to_text();
    let refused = calibrated_eye(Format::OpenCv, &both, "two.yml").unwrap_err();
    assert!(refused.to_string().contains("a rig: needed is one eye"));
    let without = both.replace("R:", "E:").replace("T:", "F:");
    let refused = calibrated_eye(Format::OpenCv, &without, "two.yml").unwrap_err();
    let told = "holds 2 cameras: keep one of them in the file";
    assert!(refused.to_string().contains(told), "{refused}");
}

#[test]
fn a_field_ends_where_its_model_ends() {
    // Ends at 116 degrees: far inside a frame of this size.
    let lens = DoubleSphere::new([100.0, 100.0], [1999.5, 1999.5], -0.2, 0.6).unwrap();
    let model = CameraModel::DoubleSphere(lens);
    let camera = CalibratedCamera {
        model,
        size_px: [4000, 4000],
    };
    let full = field_deg(&camera);
    assert!((200.0..300.0).contains(&full), "{full}");
    let section = eye(&camera, Some(full));
    let read = read::Reader { file: "f" }.camera(&section, "eye");
    assert!(read.is_ok(), "{:?}", read.err());
}

#[test]
fn a_file_is_one_rig_however_its_path_is_spelled() {
    let storage = FileStorage::of_stereo(
        [&models()[0], &models()[1]],
        [960, 720],
        &relative(&truth(), 0),
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("two.yml"), storage.to_text()).unwrap();
    let [plain, round] =
        ["two.yml", "sub/../two.yml"].map(|path| Rig::load(&folder.path().join(path)).unwrap());
    assert_eq!(plain.fingerprint(), round.fingerprint());
    assert_eq!(round.name, "two");
}

#[test]
fn a_pose_that_is_not_believed_spoils_no_lens() {
    let chain = CameraChain {
        cameras: models().each_ref().map(camera).into(),
        second_from_first: Some(Ok(relative(&truth(), 0))),
    };
    let text = kalibr::to_text(&chain).unwrap();
    let broken = text.replace("- [0.0, 0.0, 0.0, 1.0]", "- [0.0, 0.0, 0.0, 2.0]");
    assert_ne!(broken, text);
    let refused = load(&broken).unwrap_err();
    assert!(refused.contains("a last row 0, 0, 0, 1"), "{refused}");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("two.yaml"), broken).unwrap();
    let rig = "name = \"one\"\nmedium = \"air\"\nstitch_distance_m = inf\n[mount]\npsi_deg = 25.7\n\
        tau_deg = 29.15\n[right]\nfile = \"two.yaml\"\nfield_deg = 90.0\n";
    std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
    let rig = Rig::load(&folder.path().join("rig.toml")).unwrap();
    let CameraModel::KannalaBrandt(lens) = rig.right.unwrap().eye.model else {
        panic!("another lens");
    };
    assert_eq!(lens.focal_px, [303.0; 2]);
}
