//! The built program with a driver of our own (`preloaded.c`) on this machine: motion JPEG, damage
//! and gaps at known places, rows with padding, controls of exposure, what cannot be read.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use anyhow::{Context, bail, ensure};
use image::codecs::jpeg::JpegEncoder;
use serde_json::{Value, json};

/// Width and height of a frame, px.
const SIZE_PX: [usize; 2] = [320, 240];
/// Frames of each eye.
const FRAMES: usize = 30;
/// From frame to frame, and of the right eye behind the left, us.
const PERIOD_US: usize = 40_000;
const RIGHT_LATER_US: usize = 3_000;
/// A left frame that is cut, and a right one that never comes.
const CUT: usize = 7;
const LOST: usize = 12;
/// Bytes behind each row.
const PADDING: usize = 64;

/// One frame in a script for the driver.
struct Scripted {
    sequence: usize,
    time_us: usize,
    bytes: Vec<u8>,
}

/// The program with the driver.
struct Bench<'a> {
    folder: &'a Path,
    program: &'a Path,
    driver: PathBuf,
}

type Check = fn(&Bench<'_>) -> anyhow::Result<()>;

/// Makes all checks; `false` where there is no C compiler.
pub fn check(folder: &Path, program: &Path) -> anyhow::Result<bool> {
    let folder = folder.join("preloaded");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let source = folder.join("driver.c");
    fs::write(&source, include_str!("preloaded.c"))?;
    let driver = folder.join("driver.so");
    let mut compiler = Command::new("cc");
    compiler.args(["-O1", "-shared", "-fPIC", "-o"]);
    let Ok(compiled) = compiler.arg(&driver).arg(&source).arg("-ldl").status() else {
        return Ok(false);
    };
    ensure!(compiled.success(), "preloaded.c does not compile");
    for (name, device) in [("camera0", "/dev/null"), ("camera1", "/dev/zero")] {
        symlink(device, folder.join(name))?;
    }
    let bench = Bench {
        folder: &folder,
        program,
        driver,
    };
    let checks: [(&str, Check); 6] = [
        ("motion JPEG, one frame cut and one lost", motion_jpeg),
        ("motion JPEG to y4m", motion_jpeg_to_y4m),
        ("rows with padding", padding),
        ("exposure set, read back and recorded", exposure),
        ("exposure set at the page, and recorded", page),
        ("interlaced and unknown", refusals),
    ];
    for (name, check) in checks {
        check(&bench).with_context(|| format!("preloaded driver, {name}"))?;
        println!("  ok preloaded driver: {name}");
    }
    Ok(true)
}

impl Bench<'_> {
    /// Runs `tectum` with both cameras of `format`.
    fn run(
        &self,
        format: &str,
        settings: &[(&str, &str)],
        arguments: &str,
    ) -> anyhow::Result<Output> {
        Ok(self.command(format, settings, arguments).output()?)
    }

    fn command(&self, format: &str, settings: &[(&str, &str)], arguments: &str) -> Command {
        let mut command = Command::new(self.program);
        command
            .args(arguments.split_whitespace())
            .args(["--left", "camera0", "--right", "camera1"])
            .current_dir(self.folder)
            .env("LD_PRELOAD", &self.driver)
            .env("CAMERA0", self.folder.join("left.script"))
            .env("CAMERA1", self.folder.join("right.script"))
            .env("SIZE", format!("{}x{}", SIZE_PX[0], SIZE_PX[1]))
            .env("FORMAT", format)
            .env("HZ", (1_000_000 / PERIOD_US).to_string());
        command.envs(settings.iter().copied());
        command
    }

    /// As many grey frames for each eye.
    fn script_grey(&self, frames: usize) -> anyhow::Result<()> {
        let [width, height] = SIZE_PX;
        for (eye, name) in ["left", "right"].into_iter().enumerate() {
            let frame = |n| Scripted {
                sequence: n,
                time_us: n * PERIOD_US + eye * RIGHT_LATER_US,
                bytes: vec![90; width * height],
            };
            self.script(name, &(0..frames).map(frame).collect::<Vec<_>>())?;
        }
        Ok(())
    }

    /// The report of what must succeed.
    fn report(
        &self,
        format: &str,
        settings: &[(&str, &str)],
        arguments: &str,
    ) -> anyhow::Result<Value> {
        let output = self.run(format, settings, &format!("{arguments} --json"))?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{arguments}: {said}");
        Ok(serde_json::from_slice(&output.stdout)?)
    }

    /// Writes what an eye gives.
    fn script(&self, eye: &str, frames: &[Scripted]) -> anyhow::Result<()> {
        let mut script = Vec::new();
        for frame in frames {
            script.extend(u32::try_from(frame.bytes.len())?.to_ne_bytes());
            script.extend(u32::try_from(frame.sequence)?.to_ne_bytes());
            script.extend((frame.time_us as u64).to_ne_bytes());
            script.extend(&frame.bytes);
        }
        Ok(fs::write(
            self.folder.join(format!("{eye}.script")),
            script,
        )?)
    }

    fn read(&self, name: &str) -> anyhow::Result<Vec<u8>> {
        fs::read(self.folder.join(name)).with_context(|| name.to_owned())
    }
}

/// A frame that no other is like: a square that moves, on a ground that tells the eye.
fn pixel(eye: usize, n: usize, x: usize, y: usize) -> [u8; 3] {
    let is_square = (x / 16, y / 16) == (n % 20, n / 2 % 15);
    let ground = (60 + 100 * eye + x / 8) as u8;
    if is_square {
        [230, 40, (n * 8) as u8]
    } else {
        [ground, ground, (255 - y) as u8]
    }
}

fn jpeg(eye: usize, n: usize) -> anyhow::Result<Vec<u8>> {
    let [width, height] = SIZE_PX;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgb: Vec<u8> = places.flat_map(|(x, y)| pixel(eye, n, x, y)).collect();
    let mut jpeg = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, 90);
    let [width, height] = SIZE_PX.map(|px| px as u32);
    encoder.encode(&rgb, width, height, image::ExtendedColorType::Rgb8)?;
    Ok(jpeg)
}

/// Scripts of both eyes in motion JPEG, and the pictures themselves.
fn write_motion_jpeg(bench: &Bench<'_>) -> anyhow::Result<[Vec<Vec<u8>>; 2]> {
    let mut all = [Vec::new(), Vec::new()];
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let mut frames = Vec::new();
        for n in 0..FRAMES {
            let picture = jpeg(eye, n)?;
            all[eye].push(picture.clone());
            let bytes = match (eye, n) {
                // The end marker is there all the same, as after lost packets.
                (0, CUT) => [&picture[..picture.len() * 2 / 3], &[0xff, 0xd9]].concat(),
                (1, LOST) => continue,
                // As hardware pads to words.
                _ => [&picture[..], &[0; 3]].concat(),
            };
            frames.push(Scripted {
                sequence: n,
                time_us: n * PERIOD_US + eye * RIGHT_LATER_US,
                bytes,
            });
        }
        bench.script(name, &frames)?;
    }
    Ok(all)
}

/// What each eye's counters must say, to the last frame.
fn check_counts(report: &Value) -> anyhow::Result<()> {
    let counts = |eye: &str| {
        let of = |name: &str| report[eye][name].clone();
        ["frames", "corrupt", "dropped", "reconnects"].map(of)
    };
    let due = [
        ("frames", report["frames"].clone(), json!(FRAMES - 2)),
        ("left", json!(counts("left")), json!([FRAMES - 1, 1, 0, 0])),
        (
            "right",
            json!(counts("right")),
            json!([FRAMES - 1, 0, 1, 0]),
        ),
        ("alone", report["alone"].clone(), json!([1, 1])),
        ("undecodable", report["undecodable"].clone(), json!(0)),
    ];
    for (name, came, due) in due {
        ensure!(came == due, "{name}: {came} where {due} was due: {report}");
    }
    Ok(())
}

/// Numbers of the frames that have a partner.
fn paired() -> impl Iterator<Item = usize> {
    (0..FRAMES).filter(|n| ![CUT, LOST].contains(n))
}

/// Time, us, and number in the words of a recording.
fn stamp(words: &str) -> anyhow::Result<(i64, usize)> {
    let value = |key: &str| {
        let word = words.split(' ').find_map(|word| word.split_once(key));
        word.map(|(_, value)| value.trim())
            .context(format!("no {key} in {words:?}"))
    };
    Ok((
        value("TS=")?.parse::<i64>()? / 1000,
        value("SEQ=")?.parse()?,
    ))
}

/// Whether stamps of both eyes are those of frames that belong together, and exact.
fn check_stamps(stamps: [Vec<(i64, usize)>; 2]) -> anyhow::Result<()> {
    let [left, right] = stamps;
    let start_us = left.first().context("no frame")?.0;
    for (eye, stamps) in [left, right].iter().enumerate() {
        let due = paired().map(|n| {
            let since_us = n * PERIOD_US + eye * RIGHT_LATER_US;
            (start_us + since_us as i64, n)
        });
        let due: Vec<_> = due.collect();
        ensure!(
            *stamps == due,
            "eye {eye}: stamps {stamps:?} where {due:?} were due"
        );
    }
    Ok(())
}

/// Recordings are what the cameras gave, bit for bit, and pairs are of one moment.
fn motion_jpeg(bench: &Bench<'_>) -> anyhow::Result<()> {
    let pictures = write_motion_jpeg(bench)?;
    let frames = FRAMES - 2;
    let report = bench.report(
        "MJPG",
        &[],
        &format!("capture jpeg --record mjpeg --frames {frames}"),
    )?;
    check_counts(&report)?;
    let mut stamps = [Vec::new(), Vec::new()];
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let recorded = bench.read(&format!("jpeg/{name}.mjpeg"))?;
        let mut rest = &recorded[..];
        for n in paired() {
            // A start, a comment of ours, and all else as it came.
            let start = rest.get(..6).context("the recording is too short")?;
            ensure!(
                start[..4] == [0xff, 0xd8, 0xff, 0xfe],
                "{name} {n}: {start:02x?}"
            );
            let comment = 2 + usize::from(u16::from_be_bytes([start[4], start[5]]));
            stamps[eye].push(stamp(std::str::from_utf8(&rest[6..2 + comment])?)?);
            let due = [&pictures[eye][n][2..], &[0; 3]].concat();
            let came = rest.get(2 + comment..2 + comment + due.len());
            ensure!(came == Some(&due[..]), "{name}: picture {n} is another");
            rest = &rest[2 + comment + due.len()..];
        }
        ensure!(rest.is_empty(), "{name}: {} bytes are left", rest.len());
    }
    check_stamps(stamps)
}

/// First line of a y4m video, and line and planes of each frame.
type Video = (String, Vec<(String, Vec<u8>)>);

fn y4m(bytes: &[u8], plane_bytes: usize) -> anyhow::Result<Video> {
    fn line<'a>(bytes: &mut &'a [u8]) -> anyhow::Result<&'a str> {
        let end = bytes
            .iter()
            .position(|byte| *byte == b'\n')
            .context("no line")?;
        let line = std::str::from_utf8(&bytes[..end])?;
        *bytes = &bytes[end + 1..];
        Ok(line)
    }
    let mut rest = bytes;
    let header = line(&mut rest)?.to_owned();
    let mut frames = Vec::new();
    while !rest.is_empty() {
        let words = line(&mut rest)?.to_owned();
        let (planes, behind) = rest.split_at_checked(plane_bytes).context("a cut frame")?;
        frames.push((words, planes.to_vec()));
        rest = behind;
    }
    Ok((header, frames))
}

/// What is made of a camera's pictures while recording is what is made of the recorded ones.
fn motion_jpeg_to_y4m(bench: &Bench<'_>) -> anyhow::Result<()> {
    write_motion_jpeg(bench)?;
    let frames = FRAMES - 2;
    let arguments = format!("capture y4m --record y4m --frames {frames}");
    check_counts(&bench.report("MJPG", &[], &arguments)?)?;
    let mut later = Command::new(bench.program);
    later.args(
        "capture later --record y4m --left jpeg/left.mjpeg --right jpeg/right.mjpeg".split(' '),
    );
    let later = later.current_dir(bench.folder).output()?;
    ensure!(
        later.status.success(),
        "{}",
        String::from_utf8_lossy(&later.stderr)
    );
    let plane_bytes = SIZE_PX[0] * SIZE_PX[1] * 2;
    let mut stamps = [Vec::new(), Vec::new()];
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let (header, live) = y4m(&bench.read(&format!("y4m/{name}.y4m"))?, plane_bytes)?;
        let (_, later) = y4m(&bench.read(&format!("later/{name}.y4m"))?, plane_bytes)?;
        let due = "YUV4MPEG2 W320 H240 F25:1 XCOLORRANGE=FULL C422";
        ensure!(header == due, "{name}: {header:?} where {due:?} was due");
        ensure!(
            live.len() == frames && later.len() == frames,
            "{name}: {}",
            live.len()
        );
        for ((words, live), (_, later)) in live.iter().zip(&later) {
            ensure!(live == later, "{name}: pictures differ at {words}");
            stamps[eye].push(stamp(words)?);
        }
    }
    check_stamps(stamps)
}

/// What stands behind a row is never part of the picture.
fn padding(bench: &Bench<'_>) -> anyhow::Result<()> {
    let [width, height] = SIZE_PX;
    let luma =
        |eye: usize, n: usize, x: usize, y: usize| (20 + x / 2 + y / 4 + 3 * n + 9 * eye) as u8;
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let frames: Vec<_> = (0..FRAMES)
            .map(|n| {
                let row = |y: usize| {
                    let pixels = (0..width).flat_map(move |x| [luma(eye, n, x, y), (x % 2) as u8]);
                    pixels.chain(std::iter::repeat_n(0xee, PADDING))
                };
                Scripted {
                    sequence: n,
                    time_us: n * PERIOD_US + eye * RIGHT_LATER_US,
                    bytes: (0..height).flat_map(row).collect(),
                }
            })
            .collect();
        bench.script(name, &frames)?;
    }
    let row_bytes = (2 * width + PADDING).to_string();
    let arguments = format!("capture padded --record y4m --frames {FRAMES}");
    let report = bench.report("YUYV", &[("ROW_BYTES", &row_bytes)], &arguments)?;
    ensure!(report["frames"] == FRAMES, "{report}");
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let bytes = bench.read(&format!("padded/{name}.y4m"))?;
        let (header, frames) = y4m(&bytes, width * height * 2)?;
        let due = "YUV4MPEG2 W320 H240 F25:1 XCOLORRANGE=LIMITED C422";
        ensure!(header == due, "{name}: {header:?} where {due:?} was due");
        ensure!(frames.len() == FRAMES, "{name}: {} frames", frames.len());
        for (n, (_, planes)) in frames.iter().enumerate() {
            let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let mut due: Vec<u8> = places.map(|(x, y)| luma(eye, n, x, y)).collect();
            due.resize(width * height * 3 / 2, 0);
            due.resize(width * height * 2, 1);
            ensure!(*planes == due, "{name}: frame {n} is another");
        }
    }
    Ok(())
}

/// What is set on both cameras, in which order; what they made of it is said and recorded.
fn exposure(bench: &Bench<'_>) -> anyhow::Result<()> {
    bench.script_grey(FRAMES)?;
    // Asked for; and with the automatic's own time locked, which is the left camera's.
    for (asked, time, said) in [
        (
            "--exposure 50 --lock",
            48,
            "locked: exposure 4.8 ms (set was exposure 5 ms)",
        ),
        ("--lock", 160, "locked: exposure 16 ms"),
    ] {
        let notes = bench.folder.join("controls.txt");
        let _ = fs::remove_file(&notes);
        let settings = [("CONTROLS", "controls.txt")];
        let arguments = format!("capture exposed --record y4m --frames 2 {asked} --json");
        let output = bench.run("GREY", &settings, &arguments)?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{asked}: {stderr}");
        ensure!(
            stderr.lines().any(|line| line == said),
            "{asked}: no {said:?} in {stderr:?}"
        );
        let set =
            |camera| format!("{camera} auto 1\n{camera} dynamic_rate 0\n{camera} time {time}\n");
        let due = set("camera0") + &set("camera1");
        let noted = fs::read_to_string(&notes)?;
        ensure!(noted == due, "{asked}: set was\n{noted}where\n{due}was due");
        let about: Value = serde_json::from_slice(&bench.read("exposed/recording.json")?)?;
        for eye in ["left", "right"] {
            let recorded = &about[eye]["facts"]["exposure_ms"];
            let due = json!(f64::from(time) / 10.0);
            ensure!(*recorded == due, "{asked}: {recorded} where {due} was due");
        }
        fs::remove_dir_all(bench.folder.join("exposed"))?;
    }
    // Cameras without such controls.
    let output = bench.run("GREY", &[], "capture exposed --stills --frames 1 --lock")?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success() && stderr.contains("nothing is locked"),
        "--lock without controls: {stderr}"
    );
    let output = bench.run("GREY", &[], "capture refused --stills --exposure 50")?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.code() == Some(1) && stderr.contains("the controls: exposure 5 ms"),
        "--exposure without controls: {stderr}"
    );
    Ok(())
}

/// What the page sets is in the description of what is recorded from then on.
fn page(bench: &Bench<'_>) -> anyhow::Result<()> {
    bench.script_grey(8 * FRAMES)?;
    let arguments = "view --address 127.0.0.1:0 --folder page";
    let mut command = bench.command("GREY", &[("CONTROLS", "controls.txt")], arguments);
    let mut view = command
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()?;
    let asked = view.stderr.take().context("no stderr").and_then(|stderr| {
        let mut said = BufReader::new(stderr).lines();
        let notice = said.next().context("no address")??;
        let address = notice.split_once("http://").context(notice.clone())?.1;
        let (host, token) = address.split_once("/#token=").context(notice.clone())?;
        for path in [
            "/record?on=1",
            "/record?on=0",
            "/exposure?value=50",
            "/record?on=1",
            "/record?on=0",
        ] {
            post(host, token.trim(), path)?;
        }
        Ok(())
    });
    view.kill()?;
    view.wait()?;
    asked?;
    let mut recorded = Vec::new();
    for file in fs::read_dir(bench.folder.join("page"))? {
        let path = file?.path();
        if path.extension().is_some_and(|ending| ending == "json") {
            recorded.push(path);
        }
    }
    recorded.sort();
    ensure!(recorded.len() == 2, "{recorded:?}");
    // The automatic's own time is nothing that holds.
    for (path, due) in recorded.iter().zip([Value::Null, json!(4.8)]) {
        let about: Value = serde_json::from_slice(&fs::read(path)?)?;
        for eye in ["left", "right"] {
            let recorded = &about[eye]["facts"]["exposure_ms"];
            ensure!(
                *recorded == due,
                "{}, {eye}: {recorded} where {due} was due",
                path.display()
            );
        }
    }
    Ok(())
}

/// Asks a page for something that must succeed.
fn post(host: &str, token: &str, path: &str) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(host)?;
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\
         X-Tectum-Token: {token}\r\nContent-Length: 0\r\n\r\n"
    )?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer)?;
    ensure!(answer.starts_with("HTTP/1.1 200"), "{path}: {answer}");
    Ok(())
}

/// One line that says what to do.
fn refusals(bench: &Bench<'_>) -> anyhow::Result<()> {
    let interlaced: Vec<String> = (2..=9).map(|field| field.to_string()).collect();
    let fields = interlaced
        .iter()
        .map(|field| ("YUYV", ("FIELD", &**field), ["interlaced", "yadif"]));
    let codes = ["H264", "XYZ1", "YU12", "\u{1}2 3"];
    let codes = codes.map(|code| {
        (
            code,
            ("FIELD", "1"),
            ["where needed is YUYV", "ffmpeg -f v4l2 -i"],
        )
    });
    for (format, setting, parts) in fields.chain(codes) {
        let output = bench.run(format, &[setting], "capture refused --stills")?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.code() != Some(1) || said.trim().lines().count() != 1 {
            bail!("{format} {setting:?}: {:?}, {said}", output.status);
        }
        for part in parts {
            ensure!(
                said.contains(part),
                "{format} {setting:?}: no {part:?} in {said:?}"
            );
        }
    }
    Ok(())
}
