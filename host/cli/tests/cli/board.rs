//! `tectum board`: prints and their description.

use std::fs;

use crate::common::Bench;

#[test]
fn a_board_as_pdf_svg_and_png() {
    let bench = Bench::new();
    for name in ["board.pdf", "board.svg", "board.png"] {
        let json = bench.json(&format!("board --board 9x6 --square-mm 20 -o {name}"));
        assert_eq!(json["files"], serde_json::json!([name]));
        assert_eq!(json["pages"], 1);
        assert_eq!(json["page_mm"], serde_json::json!([297.0, 210.0]));
        let target = &json["targets"][0]["chessboard"];
        assert_eq!(target["square_mm"], 20.0);
        assert_eq!(target["size"]["columns"], 9);
    }
    assert!(
        fs::read(bench.path("board.pdf"))
            .unwrap()
            .starts_with(b"%PDF")
    );
    assert!(
        fs::read(bench.path("board.svg"))
            .unwrap()
            .starts_with(b"<svg")
    );
    // A4 lying at 300 dpi.
    assert_eq!(bench.picture_size("board.png"), (3508, 2480));
}

#[test]
fn the_overlap_target_says_where_its_marker_is() {
    let bench = Bench::new();
    let text = bench.done("board --board 8x6 --square-mm 20 --marker 7 --page a3 -o o/overlap.pdf");
    for part in ["id 7", "x -114 mm, y 10 mm", "100 %"] {
        assert!(text.contains(part), "{text}");
    }
    let text = fs::read_to_string(bench.path("o/overlap.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let target = &json["targets"][0]["overlap"];
    assert_eq!(
        target["marker_origin_mm"],
        serde_json::json!([-114.0, 10.0])
    );
    assert_eq!(target["marker_side_mm"], 80.0);
    assert_eq!(target["board"]["square_mm"], 20.0);
}

#[test]
fn several_pages_are_several_files() {
    let bench = Bench::new();
    let json = bench.json("board --board 9x6 --square-mm 40 -o board.svg");
    let count = json["pages"].as_u64().unwrap() as usize;
    assert!(count > 1, "{json}");
    let files = bench.files();
    assert_eq!(files.iter().filter(|f| f.ends_with(".svg")).count(), count);
    assert!(files.contains(&"board-A1.svg".to_owned()), "{files:?}");
    let json = bench.json("board --marker 3,5 --dictionary DICT_6X6_250 -o m.png --dpi 72");
    assert_eq!(json["files"], serde_json::json!(["m-1.png", "m-2.png"]));
    assert_eq!(json["targets"][1]["marker"]["id"], 5);
}

#[test]
fn bad_requests_say_what_is_allowed() {
    let bench = Bench::new();
    for (code, arguments, part) in [
        (2, "board -o a.pdf", "--board"),
        (2, "board --board 9x6 -o a.doc", ".svg"),
        (2, "board --board 9x6 -o a", ".svg"),
        (2, "board --board 9x6 --dpi 300 -o a.pdf", "--dpi"),
        (2, "board --board 1x6 -o a.pdf", "2 to 100"),
        (2, "board --board 9x6 --page a9 -o a.pdf", "tabloid"),
        (
            2,
            "board --board 9x6 --page nanxinf -o a.pdf",
            "100 to 5000",
        ),
        (2, "board --board 9x6 --marker 1,2 -o a.pdf", "one id"),
        (2, "board --marker -1 -o a.pdf", "-1"),
        (1, "board --board 9x6 --square-mm 0 -o a.pdf", "1 to 1000"),
        (1, "board --board 9x6 --square-mm -3 -o a.pdf", "1 to 1000"),
        (1, "board --board 9x6 --square-mm nan -o a.pdf", "1 to 1000"),
        (1, "board --board 9x6 --square-mm 1e9 -o a.pdf", "1 to 1000"),
        (
            1,
            "board --board 99x99 --square-mm 900 -o a.pdf",
            "larger page",
        ),
        (1, "board --marker 50 -o a.pdf", "0 to 49"),
        (1, "board --marker 4000000000 -o a.pdf", "0 to 49"),
        (
            1,
            "board --marker 1 --dictionary DICT_9X9 -o a.pdf",
            "DICT_7X7_50",
        ),
        (
            1,
            "board --marker 1 --marker-mm 1e300 -o a.pdf",
            "5 to 2000",
        ),
        (1, "board --board 9x6 --dpi 1e9 -o a.png", "36 to 2400"),
        (
            1,
            "board --board 9x6 --page 5000x5000 --dpi 2400 -o a.png",
            "lower the dpi",
        ),
    ] {
        let message = bench.refused(code, arguments);
        assert!(message.contains(part), "{arguments}: {message}");
    }
}

#[test]
fn an_overlap_target_fills_its_page_by_itself() {
    let bench = Bench::new();
    let json = bench.json("board --board 8x6 --marker 7 -o overlap.pdf");
    assert_eq!(json["pages"], 1);
    let target = &json["targets"][0]["overlap"];
    let square_mm = target["board"]["square_mm"].as_f64().unwrap();
    // Nine squares, the marker's four and the white between them across the 297 mm of A4.
    assert!((12.0..20.0).contains(&square_mm), "{json}");
    assert_eq!(target["marker_side_mm"], 4.0 * square_mm);
}
