//! `tectum board`: printable targets.

use std::path::{Path, PathBuf};

use serde_json::json;
use tectum_calibrate::target::{
    MARKER_MM, Marker, OverlapTarget, PageSize, SQUARE_MM, Sheet, Target, TargetError, TargetFile,
    pdf, sheets,
};
use tectum_calibrate::{Board, BoardSize};

use crate::files;
use crate::report::{Report, Usage};

/// Printable targets: chessboard, ArUco markers, or both as the target for the eyes' overlap
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum board --board 9x6 -o board.pdf                     the largest squares that fit A4\n  \
    tectum board --board 11x8 --square-mm 40 -o board.pdf     on several pages, to be joined\n  \
    tectum board --board 8x6 --marker 7 --page a3 -o overlap.pdf\n  \
    tectum board --marker 0,1,2 --marker-mm 120 -o markers.pdf\n  \
    tectum board --board 9x6 --square-mm 20 -o board.png --dpi 600\n\n\
    Beside the print goes its description as JSON, with the marker's place in the board's frame: \
    overlap.pdf, overlap.json. SVG and PNG hold a page each: board-A1.svg, board-A2.svg.")]
pub struct Args {
    /// Inner corners, columns x rows
    #[arg(long, value_name = "COLSxROWS")]
    board: Option<BoardSize>,
    /// Side of a square, mm [default: the most whole mm that fit one page]
    #[arg(
        long,
        value_name = "MM",
        requires = "board",
        allow_negative_numbers = true
    )]
    square_mm: Option<f64>,
    /// Ids of ArUco markers, a page each; beside a board only one
    #[arg(long, value_name = "ID,..", value_delimiter = ',')]
    marker: Vec<u32>,
    /// Dictionary of the markers, as OpenCV names it
    #[arg(
        long,
        value_name = "NAME",
        default_value = "DICT_4X4_50",
        requires = "marker"
    )]
    dictionary: String,
    /// Side of a marker's black border, mm [default: the most whole mm that fit one page; beside
    /// a board 4 squares]
    #[arg(
        long,
        value_name = "MM",
        requires = "marker",
        allow_negative_numbers = true
    )]
    marker_mm: Option<f64>,
    /// Page: a4, a3, a2, a1, a0, letter, tabloid or WxH in mm; turned as it suits
    #[arg(long, value_name = "PAGE", default_value = "a4")]
    page: PageSize,
    /// Resolution of a PNG, dots per inch [default: 300]
    #[arg(long, value_name = "DPI", allow_negative_numbers = true)]
    dpi: Option<f64>,
    /// Print to write: .pdf, .svg or .png
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Side of a marker beside a board where none is asked for, squares.
const MARKER_SQUARES: f64 = 4.0;
/// Resolution of a PNG where none is asked for.
const DEFAULT_DPI: f64 = 300.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Format {
    Pdf,
    Svg,
    Png,
}

/// Draws and writes.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let format = args.format()?;
    let targets = args.targets()?;
    let pages: Vec<Sheet> = targets
        .iter()
        .map(|target| sheets(target, args.page))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    let mut files = rendered(&pages, format, args)?;
    let description = args.output.with_extension("json");
    let targets = TargetFile { targets };
    let text = targets.to_json()? + "\n";
    files.push((description.clone(), text.into_bytes()));
    let group: Vec<(&Path, &[u8])> = files
        .iter()
        .map(|(path, bytes)| (&**path, &**bytes))
        .collect();
    files::write_group(&group)?;
    let prints = &files[..files.len() - 1];
    let names: Vec<String> = prints.iter().map(|(path, _)| name(path)).collect();
    let json = json!({
        "files": names,
        "description": name(&description),
        "pages": pages.len(),
        "page_mm": pages.first().map(Sheet::size_mm),
        "targets": targets.targets,
    });
    Ok(Report::new(
        words(&targets.targets, &pages, &names, &description),
        json,
    ))
}

impl Args {
    fn format(&self) -> anyhow::Result<Format> {
        let ending = self.output.extension().and_then(|ending| ending.to_str());
        let format = match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("pdf") => Format::Pdf,
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            _ => {
                let path = self.output.display();
                return Err(
                    Usage(format!("{path}: the name must end in .pdf, .svg or .png")).into(),
                );
            }
        };
        match self.dpi {
            Some(_) if format != Format::Png => {
                Err(Usage("--dpi is for .png: SVG and PDF have no pixels".into()).into())
            }
            _ => Ok(format),
        }
    }

    fn targets(&self) -> anyhow::Result<Vec<Target>> {
        match (self.board, self.marker.as_slice()) {
            (None, []) => {
                Err(Usage("nothing to print: give --board, --marker or both".into()).into())
            }
            (Some(size), []) => {
                let make = |square_mm| Ok(Target::Chessboard(Board { size, square_mm }));
                Ok(vec![of_size(self.square_mm, SQUARE_MM, self.page, make)?])
            }
            (Some(size), [id]) => {
                let beside = |square_mm: f64| {
                    let side_mm = self.marker_mm.unwrap_or(MARKER_SQUARES * square_mm);
                    let marker = self.of_side(*id, side_mm);
                    let board = Board { size, square_mm };
                    OverlapTarget::beside(board, marker).map(Target::Overlap)
                };
                // Squares whose marker can be printed.
                let allowed = match self.marker_mm {
                    Some(_) => SQUARE_MM,
                    None => {
                        let [least, most] =
                            [MARKER_MM.start(), MARKER_MM.end()].map(|mm| mm / MARKER_SQUARES);
                        least.ceil()..=most.min(*SQUARE_MM.end())
                    }
                };
                Ok(vec![of_size(self.square_mm, allowed, self.page, beside)?])
            }
            (Some(_), _) => Err(Usage("beside a board goes one marker: give one id".into()).into()),
            (None, ids) => Ok(ids
                .iter()
                .map(|id| {
                    let make = |side_mm| Ok(Target::Marker(self.of_side(*id, side_mm)));
                    of_size(self.marker_mm, MARKER_MM, self.page, make)
                })
                .collect::<Result<_, _>>()?),
        }
    }

    fn of_side(&self, id: u32, side_mm: f64) -> Marker {
        Marker {
            dictionary: self.dictionary.clone(),
            id,
            side_mm,
        }
    }
}

/// A target of the size asked for, or the largest.
fn of_size(
    asked_mm: Option<f64>,
    allowed: std::ops::RangeInclusive<f64>,
    page: PageSize,
    make: impl Fn(f64) -> Result<Target, TargetError>,
) -> Result<Target, TargetError> {
    match asked_mm {
        Some(mm) => make(mm),
        None => Target::largest(allowed, page, make),
    }
}

/// File names with their bytes; several pages of SVG or PNG by label or number.
fn rendered(
    pages: &[Sheet],
    format: Format,
    args: &Args,
) -> Result<Vec<(PathBuf, Vec<u8>)>, TargetError> {
    if format == Format::Pdf {
        return Ok(vec![(args.output.clone(), pdf(pages))]);
    }
    let numbered = pages.iter().enumerate();
    numbered
        .map(|(k, page)| {
            let bytes = match format {
                Format::Png => page.to_png(args.dpi.unwrap_or(DEFAULT_DPI))?,
                _ => page.to_svg().into_bytes(),
            };
            let path = match page.label() {
                _ if pages.len() == 1 => args.output.clone(),
                // Labels are unique in one target only.
                Some(label) if args.marker.len() < 2 => with_suffix(&args.output, label),
                _ => with_suffix(&args.output, &(k + 1).to_string()),
            };
            Ok((path, bytes))
        })
        .collect()
}

/// `board.svg` as `board-A1.svg`.
fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| {
        part.map_or(String::new(), |text| text.to_string_lossy().into_owned())
    };
    let (stem, ending) = (part(path.file_stem()), part(path.extension()));
    path.with_file_name(format!("{stem}-{suffix}.{ending}"))
}

fn name(path: &Path) -> String {
    path.display().to_string()
}

/// The print in words.
fn words(targets: &[Target], pages: &[Sheet], names: &[String], description: &Path) -> String {
    let mut text = names.join(", ");
    text += &format!(" and {}: ", description.display());
    let [width, height] = pages.first().map_or([0.0; 2], Sheet::size_mm);
    let count = pages.len();
    let plural = if count == 1 { "page" } else { "pages" };
    text += &format!("{count} {plural} of {width} x {height} mm\n");
    for target in targets {
        text += &format!("{target}\n");
        if let Target::Chessboard(board) = target
            && (board.size.columns + board.size.rows) % 2 == 0
        {
            text += "Turned by half a turn this board looks the same: where that matters take an \
                     odd and an even number of corners, or a marker\n";
        }
    }
    text + "Print at 100 %, no fit to page; measure both rulers"
}
