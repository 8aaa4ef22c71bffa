//! The preview in a browser.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

use serde_json::Value;

use crate::chromium::Chromium;
use crate::common::Bench;

/// `tectum view` while it runs.
struct Viewing {
    process: Child,
    url: String,
}

impl Viewing {
    fn start(bench: &Bench, arguments: &str) -> Self {
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
}

impl Drop for Viewing {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The table's answer must be the page's.
fn assert_same_as_lookup(bench: &Bench, readout: &str, eye: &str) {
    // "12.50,7.25: yaw 1.234° pitch -5.678° (left)", with the eye in front for a raw picture.
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
    let wanted = format!(
        "{:.3}° pitch {:.3}° ({shown_by})",
        said("yaw_deg"),
        said("pitch_deg")
    );
    assert_eq!(rest, wanted, "at {at}");
}

#[test]
fn the_page_shows_new_pictures_and_the_directions_of_lookup() {
    let bench = Bench::with_table();
    let Some(mut chromium) = Chromium::start() else {
        return;
    };
    let viewing = Viewing::start(&bench, "view fish.tct --source demo");
    for (size, mobile) in [([1280, 800], false), ([360, 640], true)] {
        chromium.open(&viewing.url, size, mobile);
        chromium.wait_for("document.getElementById('stitched')?.width === 160");
        chromium.wait_for("document.getElementById('left').width === 240");
        chromium.wait_for("document.getElementById('right').width === 240");
        // Each picture has a number; another number is another picture.
        let number = "Number(document.getElementById('stitched').dataset.number)";
        let before = chromium.value(number).as_f64().expect("a number");
        chromium.wait_for(&format!("{number} > {before}"));
        // Nothing is wider than the screen, and scales lie over the picture.
        chromium.wait_for("document.documentElement.scrollWidth <= window.innerWidth");
        chromium.wait_for("document.getElementById('scales').naturalWidth === 160");
        for (canvas, eye, place) in [
            ("stitched", "", [0.3, 0.4]),
            ("stitched", "", [0.62, 0.55]),
            ("left", "left", [0.5, 0.45]),
            ("right", "right", [0.4, 0.5]),
        ] {
            let script = format!(
                "(() => {{ const c = document.getElementById('{canvas}'); \
                 c.scrollIntoView({{ block: 'center' }}); const b = c.getBoundingClientRect(); \
                 return [b.left + b.width * {}, b.top + b.height * {}]; }})()",
                place[0], place[1]
            );
            let at = chromium.value(&script);
            let at = [0, 1].map(|i| at[i].as_f64().expect("a place"));
            chromium.mouse(at, true);
            let starts = if eye.is_empty() {
                "target ".to_owned()
            } else {
                format!("target {eye} ")
            };
            chromium.wait_for(&format!(
                "document.getElementById('held').textContent.startsWith('{starts}') && \
                 document.getElementById('held').textContent === \
                 'target ' + document.getElementById('readout').textContent"
            ));
            let readout = chromium.value("document.getElementById('readout').textContent");
            assert_same_as_lookup(&bench, readout.as_str().expect("text"), eye);
        }
        chromium.wait_for("/Hz/.test(document.getElementById('state').textContent)");
        chromium.wait_for("/latency/.test(document.getElementById('figures').textContent)");
    }
    assert!(chromium.complaints.is_empty(), "{:?}", chromium.complaints);
}
