//! The preview in a browser.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::chromium::Chromium;
use crate::common::Bench;

/// `tectum view` while it runs.
pub struct Viewing {
    process: Child,
    url: String,
}

impl Viewing {
    pub fn start(bench: &Bench, arguments: &str) -> Self {
        let mut process = bench
            .command(env!("CARGO_BIN_EXE_tectum"))
            .args(arguments.split_whitespace())
            .args(["--address", "127.0.0.1:0"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let stderr = BufReader::new(process.stderr.take().expect("stderr"));
        let url = stderr
            .lines()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("preview: ").map(str::to_owned))
            .expect("it says where the preview is");
        Self { process, url }
    }

    /// What the page is told, without a browser.
    fn status(&self) -> Value {
        let address = self.url.strip_prefix("http://").expect("an address");
        let (address, _) = address.split_once('/').expect("a page");
        let mut stream = TcpStream::connect(address).expect("it serves");
        write!(
            stream,
            "GET /status.json HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
        )
        .expect("it listens");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("it answers");
        let (_, body) = answer.split_once("\r\n\r\n").expect("a body");
        serde_json::from_str(body).expect("JSON")
    }

    /// Pictures shown so far.
    pub fn frames(&self) -> u32 {
        let status = self.status();
        let frames = status["figures"]["frames"].as_str();
        frames.and_then(|n| n.parse().ok()).unwrap_or(0)
    }

    /// Ends it as Ctrl-C does.
    pub fn interrupt(mut self) {
        let process = self.process.id().to_string();
        let told = Command::new("kill").args(["-INT", &process]).status();
        assert!(told.expect("kill runs").success());
        assert!(self.process.wait().expect("it ends").success());
    }
}

impl Drop for Viewing {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The table's answer must be the page's.
fn assert_same_as_lookup(bench: &Bench, readout: &str, eye: &str) {
    // "12.50,7.25: yaw 1.234° (left), pitch -5.678° (up), shown by left", with the eye in front for
    // a raw picture.
    let (at, rest) = readout
        .split_once(": yaw ")
        .unwrap_or_else(|| panic!("{readout}"));
    let at = at.rsplit(' ').next().expect("a position");
    let of = if eye.is_empty() {
        String::new()
    } else {
        format!(" --eye {eye}")
    };
    let answer: Value = bench.json(&format!("lookup fish.tct{of} --pixel {at}"));
    let said = |key: &str| answer[key].as_f64().expect("a number");
    let shown_by = answer["eye"].as_str().unwrap_or("none");
    let angle = |key: &str, [positive, negative]: [&str; 2]| {
        let side = if said(key) > 0.0 { positive } else { negative };
        format!("{:.3}° ({side})", said(key))
    };
    let wanted = format!(
        "{}, pitch {}, shown by {shown_by}",
        angle("yaw_deg", ["left", "right"]),
        angle("pitch_deg", ["down", "up"])
    );
    assert_eq!(rest, wanted, "at {at}");
}

/// Middle of an element, px, brought onto the screen.
fn middle(chromium: &mut Chromium, of: &str, [x, y]: [f64; 2]) -> [f64; 2] {
    let script = format!(
        "(() => {{ const c = document.getElementById('{of}'); \
         c.scrollIntoView({{ block: 'center' }}); const b = c.getBoundingClientRect(); \
         return [b.left + b.width * {x}, b.top + b.height * {y}]; }})()"
    );
    let at = chromium.value(&script);
    [0, 1].map(|i| at[i].as_f64().expect("a place"))
}

fn press(chromium: &mut Chromium, button: &str) {
    let at = middle(chromium, button, [0.5, 0.5]);
    chromium.mouse(at, true);
}

/// Screens that the page must fit: a phone upright and sideways, a laptop.
const SCREENS: [([u32; 2], bool); 3] =
    [([1280, 800], false), ([390, 844], true), ([844, 390], true)];

#[test]
fn the_page_shows_new_pictures_and_the_directions_of_lookup() {
    let bench = Bench::with_table();
    let Some(mut chromium) = Chromium::start() else {
        return;
    };
    let viewing = Viewing::start(&bench, "view fish.tct --source demo");
    for (size, mobile) in SCREENS {
        chromium.open(&viewing.url, size, mobile);
        chromium.wait_for("document.getElementById('stitched')?.width === 160");
        chromium.wait_for("document.getElementById('left').width === 240");
        chromium.wait_for("document.getElementById('right').width === 240");
        // Each picture has a number; another number is another picture.
        let number = "Number(document.getElementById('stitched').dataset.number)";
        let before = chromium.value(number).as_f64().expect("a number");
        chromium.wait_for(&format!("{number} > {before}"));
        // Nothing is wider than the screen, and scales are drawn for the size shown.
        chromium.wait_for("document.documentElement.scrollWidth <= window.innerWidth");
        chromium.wait_for(
            "Math.abs(document.getElementById('scales').naturalWidth \
             - document.getElementById('stitched').getBoundingClientRect().width) <= 4",
        );
        // Pictures that are live have no veil, and nothing is alarming.
        chromium.wait_for("[...document.querySelectorAll('.veil')].every((veil) => veil.hidden)");
        for (canvas, eye, place) in [
            ("stitched", "", [0.3, 0.4]),
            ("stitched", "", [0.62, 0.55]),
            ("left", "left", [0.5, 0.45]),
            ("right", "right", [0.4, 0.5]),
        ] {
            let targets = "document.getElementById('targets').rows.length";
            let before = chromium.value(targets).as_u64().expect("a count");
            let at = middle(&mut chromium, canvas, place);
            chromium.mouse(at, true);
            chromium.wait_for(&format!("{targets} === {}", before + 1));
            let of = if eye.is_empty() { "" } else { eye };
            chromium.wait_for(&format!(
                "document.getElementById('readout').textContent.startsWith('{of}') && \
                 /shown by/.test(document.getElementById('readout').textContent)"
            ));
            let readout = chromium.value("document.getElementById('readout').textContent");
            assert_same_as_lookup(&bench, readout.as_str().expect("text"), eye);
        }
        // A finger on the picture scrolls.
        let touch = "getComputedStyle(document.getElementById('stitched')).touchAction";
        let touch = chromium.value(touch);
        // What browsers call the three together: pan-x, pan-y, pinch-zoom.
        assert_eq!(touch, "manipulation");
        chromium.wait_for("/Hz/.test(document.getElementById('state').textContent)");
        chromium.wait_for("/latency/.test(document.getElementById('figures').textContent)");
    }
    assert!(chromium.complaints.is_empty(), "{:?}", chromium.complaints);
}

#[test]
fn who_has_the_token_records_and_a_program_that_is_gone_is_unmistakable() {
    let bench = Bench::with_table();
    let Some(mut chromium) = Chromium::start() else {
        return;
    };
    let viewing = Viewing::start(&bench, "view fish.tct --source demo --folder dive");
    let (bare, _) = viewing.url.split_once('#').expect("a token");
    chromium.open(bare, [1280, 800], false);
    chromium.wait_for("document.getElementById('stitched')?.width === 160");
    chromium.wait_for("facts.may_change === false && document.getElementById('operator').hidden");
    chromium.open("about:blank", [1280, 800], false);
    chromium.open(&viewing.url, [1280, 800], false);
    chromium.wait_for("facts.may_change === true && !document.getElementById('operator').hidden");
    // The token does not stay in the address.
    chromium.wait_for("location.hash === ''");
    press(&mut chromium, "snapshot");
    chromium.wait_for(
        "/^3 pictures of .* saved$/.test(document.getElementById('outcome').textContent)",
    );
    press(&mut chromium, "record");
    chromium.wait_for("facts.operator.recording?.frames > 2");
    chromium.wait_for("document.getElementById('record').ariaPressed === 'true'");
    press(&mut chromium, "record");
    chromium.wait_for("/recorded$/.test(document.getElementById('outcome').textContent)");
    chromium.wait_for("/free disk/.test(document.getElementById('figures').textContent)");
    let marks = fs::read_to_string(bench.path("dive/marks.csv")).expect("marks");
    assert_eq!(marks.lines().count(), 4, "{marks}");
    assert!(chromium.complaints.is_empty(), "{:?}", chromium.complaints);
    drop(viewing);
    chromium.wait_for("/NO CONNECTION/.test(document.getElementById('alarm').textContent)");
    chromium.wait_for(
        "!document.getElementById('alarm').hidden && \
         [...document.querySelectorAll('.veil')].every((veil) => !veil.hidden)",
    );
}

#[test]
fn one_eye_of_a_recording_without_a_table_is_shown_to_its_end_and_held() {
    let bench = Bench::new();
    bench.done("capture shot --source demo --record y4m --frames 4");
    let Some(mut chromium) = Chromium::start() else {
        return;
    };
    let viewing = Viewing::start(&bench, "view --right shot/right.y4m");
    chromium.open(&viewing.url, [390, 844], true);
    chromium.wait_for("document.getElementById('right')?.width === 240");
    chromium.wait_for("document.getElementById('left-part').hidden");
    chromium.wait_for("document.getElementById('stitched-part').hidden");
    chromium.wait_for("/end of the recording/.test(document.getElementById('state').textContent)");
    chromium.wait_for("document.getElementById('alarm').hidden");
    assert_eq!(chromium.value("facts.right.frames"), serde_json::json!(4));
    assert!(chromium.complaints.is_empty(), "{:?}", chromium.complaints);
}

#[test]
fn a_recording_begins_again_with_the_attitude_beside_it() {
    let bench = Bench::new();
    bench.done("capture shot --source demo --record y4m --frames 4");
    // Longer than the recording, whose frames may be late on a busy machine.
    let rows = (0..300).map(|i| format!("{i},{:.3},0,0,0,12.5,-3,0\n", f64::from(i) / 30.0));
    let header = "frame,time_s,x_m,y_m,z_m,yaw_deg,pitch_deg,roll_deg\n".to_owned();
    fs::write(
        bench.path("attitude.csv"),
        header + &rows.collect::<String>(),
    )
    .expect("written");
    let viewing = Viewing::start(
        &bench,
        "view --left shot/left.y4m --at-end loop --attitude attitude.csv",
    );
    let begun = Instant::now();
    loop {
        let status = viewing.status();
        // Three times the recording and more.
        if viewing.frames() > 12 {
            assert_eq!(status["attitude"]["yaw_deg"], 12.5, "{status}");
            assert_eq!(status["attitude"]["pitch_deg"], -3.0, "{status}");
            assert_eq!(status["ended"], false, "{status}");
            assert!(status["left"]["frames"].as_u64() <= Some(4), "{status}");
            // Who only watches is not told where files lie.
            assert!(status["operator"]["folder"].is_null(), "{status}");
            break;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "{status}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_recording_without_a_frame_is_an_error() {
    let bench = Bench::new();
    fs::write(bench.path("empty.y4m"), "YUV4MPEG2 W240 H240 F30:1 Cmono\n").expect("written");
    let message = bench.refused(1, "view --left empty.y4m --address 127.0.0.1:0");
    assert!(message.contains("no frame came"), "{message}");
}

/// Asks the page for a change, as whoever has the token does; the whole answer.
fn ask(url: &str, path: &str) -> String {
    let (page, token) = url.split_once("#token=").expect("a token");
    let address = page.trim_start_matches("http://").trim_end_matches('/');
    let mut stream = TcpStream::connect(address).expect("it serves");
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: {address}\r\nX-Tectum-Token: {token}\r\n\
         Content-Length: 0\r\nConnection: close\r\n\r\n"
    )
    .expect("it listens");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("it answers");
    answer
}

#[test]
fn the_page_beside_stitching_saves_records_and_marks() {
    let bench = Bench::with_table();
    let mut process = bench
        .command(env!("CARGO_BIN_EXE_tectum"))
        .args("stitch fish.tct --live --source demo -o out.y4m --view-folder kept".split(' '))
        .args(["--view", "127.0.0.1:0"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let stderr = BufReader::new(process.stderr.take().expect("stderr"));
    let mut lines = stderr.lines().map_while(Result::ok);
    let url = lines.find_map(|line| line.strip_prefix("preview: ").map(str::to_owned));
    let url = url.expect("it says where the preview is");
    let reader = std::thread::spawn(move || lines.count());
    for path in ["/record?on=1", "/mark?name=here", "/snapshot"] {
        let answer = ask(&url, path);
        assert!(answer.starts_with("HTTP/1.1 200"), "{path}: {answer}");
    }
    let told = Command::new("kill").arg(process.id().to_string()).status();
    assert!(told.is_ok_and(|status| status.success()));
    assert!(process.wait().expect("it ends").success());
    reader.join().expect("what it said");
    let kept = fs::read_dir(bench.path("kept")).expect("a folder");
    let names: Vec<_> = kept
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    for ending in [
        "-left.y4m",
        "-right.y4m",
        ".json",
        "-left.png",
        "-right.png",
        "-stitched.png",
        "marks.csv",
    ] {
        assert!(
            names.iter().any(|name| name.ends_with(ending)),
            "no {ending} in {names:?}"
        );
    }
    assert!(
        !names.iter().any(|name| name.ends_with(".part")),
        "{names:?}"
    );
    let marks = fs::read_to_string(bench.path("kept/marks.csv")).unwrap();
    assert!(marks.contains("\"here\""), "{marks}");
    let video = fs::metadata(bench.path("out.y4m")).unwrap();
    assert!(video.len() > 160 * 80 * 2);
}
