//! What the first line of a y4m video says.

use y4m::{Colorspace, Error};

use crate::{FrameFormat, Layout};

/// What the line begins with.
pub(crate) const MAGIC: &[u8] = b"YUV4MPEG2 ";

/// The parts of the line that matter here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Header {
    /// Format of the frames as a source gives them.
    pub format: FrameFormat,
    /// From frame to frame, ns.
    pub period_ns: u64,
    /// Bytes of the planes in the file: luma and twice chroma.
    pub plane_bytes: [usize; 3],
}

/// Reads the line, its end included.
///
/// # Errors
/// Why it cannot be used, and what to do.
pub(crate) fn parse(line: &[u8]) -> Result<Header, String> {
    if !line.starts_with(MAGIC) {
        return Err("not a sound y4m video: it does not begin as one".to_owned());
    }
    let tags = || {
        let words = line[MAGIC.len()..].split(|byte| byte.is_ascii_whitespace());
        words.filter(|word| !word.is_empty())
    };
    let value = |name: &[u8]| tags().filter_map(|tag| tag.strip_prefix(name)).next_back();
    if let Some(b"t" | b"b" | b"m") = value(b"I") {
        return Err(
            "is interlaced: each frame shows two moments, line by line. Make whole frames with \
             `ffmpeg -i VIDEO -vf yadif OUT.y4m`"
                .to_owned(),
        );
    }
    // Older programs name colours that the format did not know in an extension.
    let colours = value(b"C").or_else(|| value(b"XYSCSS="));
    let colours = colours.map(<[u8]>::to_ascii_lowercase);
    let mut plain = MAGIC.to_vec();
    let is_colour = |tag: &[u8]| matches!(tag.first(), Some(b'C' | b'X'));
    for tag in tags().filter(|tag| !is_colour(tag)) {
        plain.extend_from_slice(tag);
        plain.push(b' ');
    }
    if let Some(colours) = &colours {
        plain.push(b'C');
        plain.extend_from_slice(colours);
    }
    plain.push(b'\n');
    let unknown = || {
        let colours = colours.as_deref().unwrap_or_default();
        format!(
            "colours are {}: needed are 8-bit mono, 420, 422 or 444. Convert them with \
             `ffmpeg -i VIDEO -pix_fmt yuv420p OUT.y4m`",
            String::from_utf8_lossy(colours)
        )
    };
    let decoder = y4m::decode(&plain[..]).map_err(|error| match error {
        Error::UnknownColorspace => unknown(),
        Error::OutOfMemory => "not a sound y4m video: its frames are too large".to_owned(),
        error => format!("not a sound y4m video: {error}"),
    })?;
    let layout = match decoder.get_colorspace() {
        Colorspace::Cmono => Layout::Grey,
        Colorspace::C422 => Layout::Yuyv,
        Colorspace::C420 | Colorspace::C420jpeg | Colorspace::C420paldv | Colorspace::C420mpeg2 => {
            Layout::Nv12
        }
        Colorspace::C444 => Layout::Rgb24,
        _ => return Err(unknown()),
    };
    let size_px = [decoder.get_width(), decoder.get_height()];
    let [Some(width_px), Some(height_px)] = size_px.map(|px| u16::try_from(px).ok()) else {
        return Err(format!("{}x{} px is no picture", size_px[0], size_px[1]));
    };
    if matches!(layout, Layout::Nv12 | Layout::Yuyv) && width_px % 2 == 1 {
        return Err(format!(
            "an odd width ({width_px} px) with shared chroma. Give each pixel its own with \
             `ffmpeg -i VIDEO -pix_fmt yuv444p OUT.y4m`"
        ));
    }
    let range = value(b"XCOLORRANGE=").unwrap_or_default();
    let rate = decoder.get_framerate();
    let period_ns = if rate.num == 0 || rate.den == 0 {
        // Not known, as the format has it; 25 a second is what others take.
        40_000_000
    } else {
        (rate.den as f64 / rate.num as f64 * 1e9) as u64
    };
    let [width, height] = size_px;
    let chroma = match layout {
        Layout::Grey => 0,
        Layout::Nv12 => width / 2 * height.div_ceil(2),
        Layout::Yuyv => width / 2 * height,
        _ => width * height,
    };
    Ok(Header {
        format: FrameFormat {
            full_range: range.eq_ignore_ascii_case(b"FULL"),
            ..FrameFormat::packed(layout, [width_px, height_px])
        },
        period_ns: period_ns.max(1),
        plane_bytes: [width * height, chroma, chroma],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_shown_as_it_is_says_what_to_do() {
        for (line, parts) in [
            ("W4 H4 F30:1 It C420", ["interlaced", "yadif"]),
            ("W4 H4 F30:1 Ib", ["interlaced", "yadif"]),
            ("W4 H4 Im F30:1 C422", ["interlaced", "yadif"]),
            ("W4 H4 C411", ["411", "-pix_fmt"]),
            ("W4 H4 XYSCSS=411", ["411", "-pix_fmt"]),
            ("W4 H4 C420p10", ["420p10", "-pix_fmt"]),
            ("W4 H4 Cmono16", ["mono16", "-pix_fmt"]),
            ("W4 H4 C444alpha", ["444alpha", "-pix_fmt"]),
            ("W5 H4 C420", ["odd width", "-pix_fmt"]),
            ("W70000 H1 Cmono", ["70000x1", "no picture"]),
            ("W60000 H60000", ["too large", "y4m"]),
            ("W4 H0", ["y4m", "y4m"]),
            ("H4", ["y4m", "y4m"]),
            ("W-4 H4", ["y4m", "y4m"]),
            ("W4 H4 F30", ["y4m", "y4m"]),
        ] {
            let error = parse(format!("YUV4MPEG2 {line}\n").as_bytes()).unwrap_err();
            for part in parts {
                assert!(error.contains(part), "{line}: {error}");
            }
        }
        assert!(parse(b"no video").is_err());
    }

    #[test]
    fn odd_parameters_of_sound_videos_are_read() {
        let read = |line: &str| parse(format!("YUV4MPEG2 {line}\n").as_bytes()).unwrap();
        for line in [
            "W4 H3 F25:1 Ip A1:1 C420jpeg",
            "C420jpeg H3 W4",
            "W4  H3 F25:1 I? A0:0 C420mpeg2 XYSCSS=420MPEG2 Xanything",
            "W4 H3 F0:0",
            "W4 H3 XYSCSS=420JPEG\r",
        ] {
            let header = read(line);
            assert_eq!(header.format.layout, Layout::Nv12, "{line}");
            assert_eq!(header.format.size_px, [4, 3], "{line}");
            assert_eq!(header.plane_bytes, [12, 4, 4], "{line}");
            assert_eq!(header.period_ns, 40_000_000, "{line}");
            assert!(!header.format.full_range, "{line}");
        }
        assert!(read("W4 H3 C444 XCOLORRANGE=FULL").format.full_range);
        assert!(!read("W4 H3 XCOLORRANGE=LIMITED").format.full_range);
        // No range, but a word that holds one.
        assert!(!read("W4 H3 XNOT-COLORRANGE=FULL").format.full_range);
        assert_eq!(read("W4 H3 XYSCSS=422").format.layout, Layout::Yuyv);
    }
}
