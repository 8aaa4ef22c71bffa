use super::sheet::{Rect, Text};
use super::*;
use crate::BoardSize;

fn chessboard(columns: u16, rows: u16, square_mm: f64) -> Target {
    Target::Chessboard(Board {
        size: BoardSize { columns, rows },
        square_mm,
    })
}

fn marker(dictionary: &str, id: u32, side_mm: f64) -> Marker {
    Marker {
        dictionary: dictionary.into(),
        id,
        side_mm,
    }
}

fn overlap(square_mm: f64) -> Target {
    let Target::Chessboard(board) = chessboard(8, 6, square_mm) else {
        unreachable!()
    };
    let marker = marker("DICT_5X5_100", 42, 4.0 * square_mm);
    Target::Overlap(OverlapTarget::beside(board, marker).unwrap())
}

fn page(text: &str) -> PageSize {
    text.parse().unwrap()
}

fn area(rects: &[Rect]) -> f64 {
    rects.iter().map(|r| r.size_mm()[0] * r.size_mm()[1]).sum()
}

fn bounds(rects: &[Rect]) -> Rect {
    let all = rects.iter().copied();
    all.reduce(|a, b| a.around(&b)).unwrap()
}

#[test]
fn a_board_is_squares_to_scale() {
    let sheets = sheets(&chessboard(4, 3, 20.0), page("a4")).unwrap();
    let [sheet] = sheets.as_slice() else {
        panic!("{} pages", sheets.len())
    };
    // 5 x 4 squares, the top left one black.
    assert_eq!((sheet.size_mm(), sheet.label()), ([297.0, 210.0], None));
    let [left, top] = bounds(&sheet.target).min_mm;
    let mut black: Vec<[f64; 2]> = vec![];
    for rect in &sheet.target {
        let [w, h] = rect.size_mm();
        // Rounding of sums of some hundred mm.
        assert!((w - 20.0).abs() < 1e-9 && (h - 20.0).abs() < 1e-9);
        let [x, y] = rect.min_mm;
        black.push([((x - left) / 20.0).round(), ((y - top) / 20.0).round()]);
    }
    let expected: Vec<[f64; 2]> = (0..20)
        .map(|k| [k % 5, k / 5])
        .filter(|[i, j]| (i + j) % 2 == 0)
        .map(|place| place.map(f64::from))
        .collect();
    assert_eq!(black, expected);
}

#[test]
fn a_print_lies_on_the_page_and_nothing_on_the_target() {
    let cases = [
        (chessboard(9, 6, 20.0), "a4"),
        (chessboard(6, 9, 20.0), "letter"),
        (chessboard(4, 3, 10.0), "100x100"),
        (overlap(20.0), "a3"),
        (overlap(100.0), "a1"),
        (overlap(60.0), "a4"),
        (
            Target::Marker(marker("DICT_APRILTAG_36h11", 586, 130.0)),
            "a4",
        ),
    ];
    for (target, name) in cases {
        for sheet in sheets(&target, page(name)).unwrap() {
            let paper = Rect::new([0.0; 2], sheet.size_mm()).grown(-5.0);
            let bounds = bounds(&sheet.target);
            for rect in sheet.target.iter().chain(&sheet.marks) {
                assert_eq!(rect.within(&paper), Some(*rect), "{target:?}");
            }
            let clear = |rect: &Rect| rect.within(&bounds).is_none();
            assert!(sheet.marks.iter().all(clear), "{target:?}");
            for text in &sheet.texts {
                let width = Text::width_mm(text.text.len(), text.em_mm);
                let [x, y] = text.at_mm;
                let size = [width, 0.95 * text.em_mm];
                let place = Rect::new([x, y - 0.72 * text.em_mm], size);
                assert!(place.within(&paper) == Some(place), "{target:?} {text:?}");
                assert!(clear(&place), "{target:?} {text:?}");
                assert!(text.text.is_ascii() && !text.text.contains(['<', '&']));
            }
        }
    }
}

#[test]
fn rulers_are_100_mm_where_the_page_allows_it() {
    for (name, expected) in [("a4", [100, 100]), ("100x160", [60, 90])] {
        let sheets = sheets(&chessboard(3, 4, 5.0), page(name)).unwrap();
        let longest = |axis: usize| {
            let lengths = sheets[0].marks.iter().map(|mark| mark.size_mm()[axis]);
            // The line reaches half its width beyond either end.
            (lengths.fold(0.0, f64::max) - ruler::LINE_MM).round() as i32
        };
        assert_eq!([longest(0), longest(1)], expected, "{name}");
    }
}

#[test]
fn pages_cover_the_target_exactly_once_and_cut_no_corner() {
    for (target, name) in [
        (chessboard(9, 6, 60.0), "a4"),
        (chessboard(11, 8, 100.0), "a3"),
        (overlap(50.0), "letter"),
        (Target::Marker(marker("DICT_4X4_50", 3, 400.0)), "a4"),
    ] {
        let sheets = sheets(&target, page(name)).unwrap();
        assert!(sheets.len() > 1, "{target:?}");
        let all = artwork::ink(&target).unwrap();
        let printed: f64 = sheets.iter().map(|sheet| area(&sheet.target)).sum();
        // Rounding of some hundred areas of some 1e4 mm2.
        assert!((printed - area(&all)).abs() < 1e-6, "{target:?}");
        let labels: Vec<_> = sheets.iter().filter_map(Sheet::label).collect();
        assert_eq!((labels.len(), labels[0]), (sheets.len(), "A1"));
        // Squares and their parts are wide: no cut shaves one.
        for rect in sheets.iter().flat_map(|sheet| &sheet.target) {
            assert!(rect.size_mm().iter().all(|mm| *mm > 6.0), "{target:?}");
        }
    }
}

#[test]
fn each_square_is_on_the_pages_once() {
    let target = chessboard(7, 5, 60.0);
    let (outline, edges) = (
        artwork::outline(&target).unwrap(),
        artwork::edges(&target).unwrap(),
    );
    let along =
        |k: usize| tiling::cuts(outline.min_mm[k], outline.max_mm[k], &edges[k], 170.0).unwrap();
    let (xs, ys) = (along(0), along(1));
    assert!(xs.len() > 3 && ys.len() > 2);
    for square in artwork::ink(&target).unwrap() {
        let mut covered = 0.0;
        for x in xs.windows(2) {
            for y in ys.windows(2) {
                let tile = Rect {
                    min_mm: [x[0], y[0]],
                    max_mm: [x[1], y[1]],
                };
                covered += square.within(&tile).map_or(0.0, |part| area(&[part]));
            }
        }
        // Rounding.
        assert!((covered - 3600.0).abs() < 1e-9);
    }
}

#[test]
fn svg_holds_every_rectangle_in_mm() {
    let sheet = &sheets(&overlap(20.0), page("a3")).unwrap()[0];
    let svg = sheet.to_svg();
    assert!(svg.contains("width=\"420mm\" height=\"297mm\" viewBox=\"0 0 420 297\""));
    let path = svg.split("id=\"target\" d=\"").nth(1).unwrap();
    let path = path.split('"').next().unwrap();
    let drawn: Vec<&str> = path.split_inclusive('Z').collect();
    assert_eq!(drawn.len(), sheet.target.len());
    for (text, rect) in drawn.iter().zip(&sheet.target) {
        let numbers: Vec<f64> = text
            .split(['M', ' ', 'H', 'V', 'Z'])
            .filter_map(|number| number.parse().ok())
            .collect();
        let ([x0, y0], [x1, y1]) = (rect.min_mm, rect.max_mm);
        for (number, expected) in numbers.iter().zip([x0, y0, x1, y1, x0]) {
            // Numbers are rounded to 1e-4 mm.
            assert!((number - expected).abs() <= 0.5001e-4, "{text}");
        }
        assert_eq!(numbers.len(), 5);
    }
    assert!(svg.contains(" Marker DICT_5X5_100, id 42, side 80 mm</text>"));
}

#[test]
fn pdf_holds_every_rectangle_and_page_to_scale() {
    let sheets = sheets(&chessboard(9, 6, 60.0), page("a4")).unwrap();
    let bytes = pdf(&sheets);
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.starts_with("%PDF-1."));
    assert_eq!(text.matches("/Type /Page\n").count(), sheets.len());
    assert!(text.contains("/PrintScaling /None"));
    let rects: usize = sheets.iter().map(|s| s.target.len() + s.marks.len()).sum();
    let drawn: Vec<&str> = text.lines().filter(|line| line.ends_with(" re")).collect();
    assert_eq!(drawn.len(), rects);
    // A whole square, mm under a matrix of points a mm.
    assert!(drawn.iter().any(|line| line.ends_with(" 60 60 re")));
    let matrix = text.lines().find(|line| line.ends_with(" cm")).unwrap();
    let numbers: Vec<f64> = matrix.split(' ').filter_map(|n| n.parse().ok()).collect();
    let height = sheets[0].size_mm()[1] * 72.0 / 25.4;
    for (number, expected) in numbers
        .iter()
        .zip([72.0 / 25.4, 0.0, 0.0, -72.0 / 25.4, 0.0, height])
    {
        // 32-bit numbers.
        assert!((number - expected).abs() < 1e-4, "{matrix}");
    }
    assert!(text.contains("(A2) Tj"));
}

#[test]
fn png_is_to_scale_between_pixels_too() {
    let sheet = &sheets(&chessboard(4, 3, 12.34), page("a4")).unwrap()[0];
    let bytes = sheet.to_png(100.0).unwrap();
    let reader = ::png::Decoder::new(std::io::Cursor::new(&bytes))
        .read_info()
        .unwrap();
    let dims = reader.info().pixel_dims.unwrap();
    assert_eq!(
        (dims.xppu, dims.yppu, dims.unit),
        (3937, 3937, ::png::Unit::Meter)
    );
    let picture = image::load_from_memory(&bytes).unwrap().into_luma8();
    let px_per_mm = 3.937;
    assert_eq!(picture.dimensions(), (1169, 827));
    let dark = |x: u32, y: u32| f64::from(255 - picture.get_pixel(x, y)[0]) / 255.0;
    let bounds = bounds(&sheet.target);
    // A row through the middle of the first squares: three black ones of five.
    let y = ((bounds.min_mm[1] + 6.0) * px_per_mm) as u32;
    let from = ((bounds.min_mm[0] - 3.0) * px_per_mm) as u32;
    let to = ((bounds.max_mm[0] + 3.0) * px_per_mm) as u32;
    let black: f64 = (from..to).map(|x| dark(x, y)).sum();
    // Six edges rounded to 1/255 px.
    assert!(
        (black - 3.0 * 12.34 * px_per_mm).abs() < 6.0 / 510.0,
        "{black}"
    );
    let moment: f64 = (from..to).map(|x| dark(x, y) * (f64::from(x) + 0.5)).sum();
    let middle = (bounds.min_mm[0] + bounds.max_mm[0]) / 2.0 * px_per_mm;
    // The same rounding, at most half the board's 240 px from the middle of 146 px of black.
    assert!((moment / black - middle).abs() < 0.01);
}

#[test]
fn a_marker_is_drawn_upright() {
    let marker = marker("DICT_4X4_50", 0, 60.0);
    let sheet = &sheets(&Target::Marker(marker.clone()), page("a4")).unwrap()[0];
    let [left, top] = bounds(&sheet.target).min_mm;
    let picture = image::load_from_memory(&sheet.to_png(50.0).unwrap())
        .unwrap()
        .into_luma8();
    let rows: Vec<String> = (0..6)
        .map(|y| {
            let at =
                |start: f64, k: i32| ((start + f64::from(k) * 10.0 + 5.0) / 25.4 * 50.0) as u32;
            let white = |x: i32| picture.get_pixel(at(left, x), at(top, y))[0] > 127;
            (0..6).map(|x| if white(x) { '.' } else { '#' }).collect()
        })
        .collect();
    let drawn = ["######", "#.#..#", "##.#.#", "###..#", "###.##", "######"];
    assert_eq!(rows, drawn);
}

#[test]
fn the_largest_target_fits_and_one_mm_more_does_not() {
    let make = |square_mm: f64| Ok(chessboard(9, 6, square_mm));
    let a4 = page("a4");
    let Ok(Target::Chessboard(board)) = Target::largest(SQUARE_MM, a4, make) else {
        panic!()
    };
    let pages = |mm: f64| sheets(&chessboard(9, 6, mm), a4).unwrap().len();
    assert_eq!(pages(board.square_mm), 1);
    assert!(pages(board.square_mm + 1.0) > 1);
    let make = |square_mm: f64| Ok(chessboard(100, 100, square_mm));
    let tiny = Target::largest(SQUARE_MM, page("100x100"), make);
    assert!(matches!(tiny, Err(TargetError::DoesNotFit { .. })));
}

#[test]
fn hostile_numbers_are_refused_with_what_is_allowed() {
    let says = |target: &Target, name: &str, part: &str| {
        let error = sheets(target, page(name)).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    for mm in [0.0, -20.0, f64::NAN, f64::INFINITY, 1e9] {
        says(&chessboard(9, 6, mm), "a4", "1 to 1000");
        let marker = marker("DICT_4X4_50", 0, mm);
        says(&Target::Marker(marker), "a4", "5 to 2000");
    }
    says(&chessboard(0, 6, 20.0), "a4", "2 to 100");
    says(&chessboard(9, 65535, 20.0), "a4", "2 to 100");
    says(&chessboard(100, 100, 1000.0), "a4", "larger page");
    says(&chessboard(50, 50, 150.0), "a4", "larger page");
    let sheet = &sheets(&chessboard(9, 6, 20.0), page("5000x5000")).unwrap()[0];
    for dpi in [0.0, f64::NAN, 1e9, -300.0] {
        let error = sheet.to_png(dpi).unwrap_err().to_string();
        assert!(error.contains("36 to 2400"), "{error}");
    }
    let error = sheet.to_png(2400.0).unwrap_err().to_string();
    assert!(error.contains("lower the dpi"), "{error}");
}
