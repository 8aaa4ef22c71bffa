//! Registration in one call, of pictures in memory.

use std::path::Path;
use std::sync::Mutex;

use image::{Rgb, RgbImage};
use nalgebra::Vector3;
use tectum_optics::Rig;
use tectum_optics::convention::yaw_pitch;
use tectum_stitch::Eyes;
use tectum_stitch::distance::Toward;
use tectum_stitch::session::{
    Input, Options, Poses, Registered, SeamChoice, SessionError, Step, ToneMatch, WantedDistance,
    html, register_pictures,
};

fn rig() -> Rig {
    let eye = |yaw_deg: f64| {
        format!(
            "size_px = [240, 240]\nfield_deg = 208.0\n\
             pose = {{ yaw_deg = {yaw_deg}, pitch_deg = 0.0, position_mm = [0.0, 0.0, 0.0] }}\n\
             lens = {{ model = 'equidistant', focal_px_per_rad = 65.0, centre_px = [119.5, 119.5] }}\n"
        )
    };
    let text = format!(
        "name = 'pair'\nmedium = 'air'\nstitch_distance_m = 2.0\n[left]\n{}[right]\n{}",
        eye(90.0),
        eye(-90.0)
    );
    Rig::from_toml(&text, "pair").unwrap()
}

/// What both eyes see of a far pattern, the right one darker by a fifth.
fn pictures(rig: &Rig) -> Eyes<RgbImage> {
    [(&rig.left, 1.0), (&rig.right, 0.8)].map(|(eye, gain)| {
        let eye = eye.as_ref().unwrap();
        RgbImage::from_fn(240, 240, |x, y| {
            let Ok(ray) = eye.eye.unproject([f64::from(x), f64::from(y)]) else {
                return Rgb([0; 3]);
            };
            let ray: Vector3<f64> = eye.pose.rotation * ray;
            let (yaw, pitch) = yaw_pitch(&ray);
            let wave = (11.0 * yaw + 3.0 * (5.0 * pitch).sin()).sin() * (7.0 * pitch).cos();
            Rgb([(gain * (110.0 + 50.0 * wave)) as u8; 3])
        })
    })
}

fn register(pairs: &Vec<Eyes<RgbImage>>, options: &Options) -> Result<Registered, SessionError> {
    let input = Input {
        rig: &rig(),
        rig_file: Path::new("out/fish.toml"),
        pairs,
        scene: None,
    };
    register_pictures(&input, options, &|_| {})
}

fn options() -> Options {
    Options {
        poses: Poses::Keep,
        distance: WantedDistance::Metres(3.0),
        toward: Toward::Everywhere,
        size_px: [320, 160],
        tone: ToneMatch::Match,
        seam: SeamChoice::CutAndBend,
        width_px: Some(512),
    }
}

#[test]
fn pictures_in_memory_become_a_rig_with_its_files_and_a_page() {
    let rig = rig();
    let steps = Mutex::new(Vec::new());
    let input = Input {
        rig: &rig,
        rig_file: Path::new("out/fish.toml"),
        pairs: &vec![pictures(&rig)],
        scene: None,
    };
    let found = register_pictures(&input, &options(), &|step| {
        steps.lock().unwrap().push(step);
    });
    let found = found.unwrap();
    let steps = steps.into_inner().unwrap();
    assert_eq!(
        steps,
        [
            Step::Matching,
            Step::Distance,
            Step::Appearance,
            Step::Stitching
        ]
    );
    let stitching = found.files.rig().stitching.as_ref().unwrap();
    assert!(stitching.seam.is_some() && stitching.tone.is_some());
    assert_eq!(found.files.rig().stitch_distance_m, 3.0);
    let colour = found.appearance.colour.unwrap();
    assert!(colour.after.mean_abs < colour.before.mean_abs / 4.0);
    assert!(found.cost.after.is_ok() && found.agreeing().is_none());
    // The rig is written last, in the folder of its pictures.
    let (last, _) = found.files.to_write().last().unwrap();
    assert_eq!(last, input.rig_file);
    let mut files = found.files.to_write();
    assert!(files.all(|(path, bytes)| path.starts_with("out") && !bytes.is_empty()));
    let page = html(&found, &["Look here".to_owned()]);
    assert!(page.contains("Registration of rig fish") && page.contains("Look here"));
}

#[test]
fn pictures_that_are_none_or_of_another_camera_are_refused() {
    let none = register(&Vec::new(), &options()).unwrap_err();
    assert!(matches!(none, SessionError::NoPictures), "{none}");
    let small = [RgbImage::new(240, 240), RgbImage::new(120, 240)];
    let refused = register(&vec![small], &options()).unwrap_err();
    assert!(
        matches!(refused, SessionError::Size { eye: "right", .. }),
        "{refused}"
    );
}

#[test]
fn errors_name_things_and_no_arguments() {
    let pairs = vec![pictures(&rig())];
    let boards = Options {
        distance: WantedDistance::OfBoards,
        ..options()
    };
    let refused = register(&pairs, &boards).unwrap_err().to_string();
    assert!(
        refused.contains("no corners of boards") && !refused.contains("--"),
        "{refused}"
    );
}
