//! Frames of every layout, padded or not, are stitched as the core stitches them packed.

use tectum_bake::convert::from_rgb8;
use tectum_bake::{BakeOptions, Format, Pass, bake, stitch};
use tectum_capture::{
    Bayer, CaptureError, Frame, FrameFormat, Layout, LiveStitcher, Pair, to_rgb8,
};
use tectum_core::{Sampler, Tables};
use tectum_optics::{Projection, Rig};

const SIDE: u16 = 96;

fn table() -> Vec<u8> {
    let eye = "size_px = [96, 96]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
               focal_px_per_rad = 26.0, centre_px = [47.5, 47.5] }\n";
    let text = format!(
        "name = 'small'\nmedium = 'air'\nstitch_distance_m = inf\n[mount]\npsi_deg = 20.0\n\
         tau_deg = 10.0\n[left]\n{eye}[right]\n{eye}"
    );
    let rig = Rig::from_toml(&text, "small").unwrap();
    let options = BakeOptions {
        output: Projection::Equirect.output_map([120, 60]).unwrap(),
        max_error_px: 1.0,
        feather_rad: 0.2,
    };
    bake(&rig, &options).unwrap().bytes
}

fn rgb(seed: usize) -> Vec<u8> {
    let bytes = usize::from(SIDE) * usize::from(SIDE) * 3;
    (0..bytes).map(|i| (i * seed % 251) as u8).collect()
}

/// `packed` with `padding` bytes of rubbish after each row.
fn padded(packed: &[u8], row: usize, padding: usize) -> Vec<u8> {
    packed
        .chunks(row)
        .flat_map(|line| {
            line.iter()
                .copied()
                .chain(std::iter::repeat_n(0xa5, padding))
        })
        .collect()
}

fn frame(data: &[u8], format: FrameFormat) -> Frame<'_> {
    Frame {
        data,
        format,
        time_ns: 0,
        sequence: 0,
        superseded: false,
    }
}

#[test]
fn every_layout_gives_the_bytes_of_the_core() {
    let bytes = table();
    let tables = Tables::parse(&bytes).unwrap();
    for (layout, format) in [
        (Layout::Grey, Format::Gray8),
        (Layout::Yuyv, Format::Yuyv),
        (Layout::Uyvy, Format::Uyvy),
        (Layout::Rgb565, Format::Rgb565),
        (Layout::Rgb565Be, Format::Rgb565Be),
        (Layout::Rgb24, Format::Rgb8),
    ] {
        let eyes = [31, 57].map(|seed| from_rgb8(format, SIDE.into(), &rgb(seed)));
        let pair = tectum_bake::Pair {
            left: &eyes[0],
            right: &eyes[1],
        };
        let wanted = stitch(&tables, format, Sampler::Bilinear, Pass::Both, pair).unwrap();
        for padding in [0, 32] {
            let packed = FrameFormat::packed(layout, [SIDE, SIDE]);
            let given = FrameFormat {
                stride_bytes: packed.stride_bytes + padding,
                ..packed
            };
            let [left, right] = eyes
                .each_ref()
                .map(|e| padded(e, packed.stride_bytes, padding));
            let pair = Pair {
                left: frame(&left, given),
                right: frame(&right, given),
            };
            let mut stitcher = LiveStitcher::new(&tables, Sampler::Bilinear);
            let stitched = stitcher.stitch(&pair).unwrap().unwrap();
            assert!(
                stitched == wanted,
                "{layout} with {padding} bytes of padding"
            );
        }
    }
}

#[test]
fn a_sensor_s_colours_are_stitched_as_the_rgb_that_they_become() {
    let bytes = table();
    let tables = Tables::parse(&bytes).unwrap();
    for bayer in Bayer::ALL {
        let packed = FrameFormat::packed(Layout::Bayer(bayer), [SIDE, SIDE]);
        let format = FrameFormat {
            stride_bytes: packed.stride_bytes + 16,
            ..packed
        };
        let eyes = [31, 57].map(|seed| {
            let bytes = (0..format.frame_bytes()).map(|i| (i * seed % 251) as u8);
            bytes.collect::<Vec<u8>>()
        });
        let [left, right] = eyes.each_ref().map(|data| frame(data, format));
        let [left_rgb, right_rgb] = [&left, &right].map(|frame| to_rgb8(frame).unwrap());
        let rgb = tectum_bake::Pair {
            left: &left_rgb,
            right: &right_rgb,
        };
        let wanted = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, rgb).unwrap();
        let mut stitcher = LiveStitcher::new(&tables, Sampler::Bilinear);
        let stitched = stitcher.stitch(&Pair { left, right }).unwrap().unwrap();
        assert!(stitched == wanted, "{bayer:?}");
    }
}

#[test]
fn nv12_is_stitched_as_the_yuyv_that_it_unpacks_to() {
    let bytes = table();
    let tables = Tables::parse(&bytes).unwrap();
    let side = usize::from(SIDE);
    let planes = [7, 11].map(|seed| {
        let luma: Vec<u8> = (0..side * side).map(|i| (i * seed % 249) as u8).collect();
        let chroma: Vec<u8> = (0..side * side / 2)
            .map(|i| (i * seed % 247) as u8)
            .collect();
        (luma, chroma)
    });
    let yuyv = planes.each_ref().map(|(luma, chroma)| {
        (0..side * side / 2)
            .flat_map(|pair| {
                let (x, y) = (pair * 2 % side, pair * 2 / side);
                let at = y / 2 * side + x;
                [
                    luma[pair * 2],
                    chroma[at],
                    luma[pair * 2 + 1],
                    chroma[at + 1],
                ]
            })
            .collect::<Vec<u8>>()
    });
    let wanted = stitch(
        &tables,
        Format::Yuyv,
        Sampler::Bilinear,
        Pass::Both,
        tectum_bake::Pair {
            left: &yuyv[0],
            right: &yuyv[1],
        },
    )
    .unwrap();
    let nv12 = planes.map(|(luma, chroma)| [luma, chroma].concat());
    let format = FrameFormat::packed(Layout::Nv12, [SIDE, SIDE]);
    let pair = Pair {
        left: frame(&nv12[0], format),
        right: frame(&nv12[1], format),
    };
    let mut stitcher = LiveStitcher::new(&tables, Sampler::Bilinear);
    assert!(stitcher.stitch(&pair).unwrap().unwrap() == wanted);
}

#[test]
fn frames_that_do_not_fit_are_refused_and_broken_ones_passed_over() {
    let bytes = table();
    let tables = Tables::parse(&bytes).unwrap();
    let mut stitcher = LiveStitcher::new(&tables, Sampler::Nearest);
    let small = FrameFormat::packed(Layout::Grey, [8, 8]);
    let pair = Pair {
        left: frame(&[0; 64], small),
        right: frame(&[0; 64], small),
    };
    let error = stitcher.stitch(&pair).unwrap_err();
    assert!(matches!(error, CaptureError::Stitch(_)), "{error}");
    let jpeg = FrameFormat::packed(Layout::Mjpeg, [SIDE, SIDE]);
    let pair = Pair {
        left: frame(b"\xff\xd8 broken", jpeg),
        right: frame(b"\xff\xd8 broken", jpeg),
    };
    assert!(stitcher.stitch(&pair).unwrap().is_none());
}
