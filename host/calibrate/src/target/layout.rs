//! Targets on pages, with rulers, caption and crop marks.

use super::artwork::{edges, ink, outline};
use super::ruler::{DEPTH_MM, LINE_MM, ruler};
use super::sheet::{Rect, Sheet, Text};
use super::tiling::cuts;
use super::{PageSize, Target, TargetError};

/// White all round: more than printers leave unprinted.
const MARGIN_MM: f64 = 10.0;
/// Size of the caption's font and distance of its lines.
const EM_MM: f64 = 2.6;
const LEADING_MM: f64 = 3.5;
/// Length of a ruler where the page allows it.
const RULER_MM: f64 = 100.0;
/// Below this, the caption goes under the ruler instead of beside it.
const CAPTION_MM: f64 = 65.0;
/// Lines that a caption takes on a narrow page; twice as wide they are half as many. The space is
/// kept on every page, so that the space for the target does not depend on the text.
const CAPTION_LINES: usize = 8;
/// Between ruler and target, and ruler and caption.
const GAP_MM: f64 = 3.0;
/// Most pages.
const MAX_PAGES: usize = 100;
/// Most pages along a side: letters are row names.
const MAX_SIDE: usize = 26;

/// The areas of a page.
#[derive(Debug, Clone, Copy)]
struct Frame {
    size_mm: [f64; 2],
    /// Space for the target.
    area: Rect,
    rulers_mm: [u32; 2],
    caption_at_mm: [f64; 2],
    caption_width_mm: f64,
}

impl Frame {
    fn new(size_mm: [f64; 2]) -> Self {
        let [width, height] = size_mm;
        let left = MARGIN_MM + DEPTH_MM + GAP_MM;
        let tens = |mm: f64| (mm.min(RULER_MM) / 10.0) as u32 * 10;
        // The last number is wider than its tick.
        let ruler_x = tens(width - left - MARGIN_MM - 5.0);
        let beside = left + f64::from(ruler_x) + 4.0 * GAP_MM;
        let block = CAPTION_LINES as f64 * LEADING_MM;
        let (caption_x, foot, caption_down) = if width - MARGIN_MM - beside >= CAPTION_MM {
            let foot = (block / 2.0).max(DEPTH_MM);
            (beside, foot, 0.0)
        } else {
            (left, DEPTH_MM + GAP_MM + block, DEPTH_MM + GAP_MM)
        };
        let bottom = height - MARGIN_MM - foot;
        let area = Rect {
            min_mm: [left, MARGIN_MM],
            max_mm: [width - MARGIN_MM, bottom - GAP_MM],
        };
        Self {
            size_mm,
            area,
            rulers_mm: [ruler_x, tens(area.size_mm()[1])],
            caption_at_mm: [caption_x, bottom + caption_down + 0.7 * EM_MM],
            caption_width_mm: width - MARGIN_MM - caption_x,
        }
    }

    /// A page with everything but the target.
    fn sheet(&self, caption: &[String], label: Option<String>) -> Sheet {
        let (mut marks, mut texts) = (vec![], vec![]);
        let [x, y] = [self.area.min_mm[0], self.area.max_mm[1] + GAP_MM];
        ruler(0, [x, y], self.rulers_mm[0], &mut marks, &mut texts);
        let origin = [x - GAP_MM, self.area.min_mm[1]];
        ruler(1, origin, self.rulers_mm[1], &mut marks, &mut texts);
        let lines = wrap(caption, Text::capacity(self.caption_width_mm, EM_MM));
        for (k, text) in lines.into_iter().enumerate() {
            let [x, y] = self.caption_at_mm;
            texts.push(Text {
                at_mm: [x, y + k as f64 * LEADING_MM],
                em_mm: EM_MM,
                text,
            });
        }
        texts.extend(label.clone().map(|text| Text {
            at_mm: [MARGIN_MM, self.size_mm[1] - MARGIN_MM],
            em_mm: 6.0,
            text,
        }));
        Sheet {
            label,
            size_mm: self.size_mm,
            target: vec![],
            marks,
            texts,
        }
    }
}

/// Lines of at most `characters`, broken between words.
fn wrap(paragraphs: &[String], characters: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for paragraph in paragraphs {
        lines.push(String::new());
        for word in paragraph.split(' ') {
            match lines.last_mut() {
                Some(line) if line.is_empty() => line.push_str(word),
                Some(line) if line.len() + 1 + word.len() <= characters => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
    }
    lines
}

/// Where a target is cut for pages like `frame`: positions along x and y.
fn grid(target: &Target, frame: &Frame) -> Result<Option<[Vec<f64>; 2]>, TargetError> {
    let (outline, edges, room) = (outline(target)?, edges(target)?, frame.area.size_mm());
    let along = |k: usize| cuts(outline.min_mm[k], outline.max_mm[k], &edges[k], room[k]);
    Ok(along(0).zip(along(1)).map(|(x, y)| [x, y]))
}

/// A target fits one page.
pub(super) fn fits(target: &Target, page: PageSize) -> Result<bool, TargetError> {
    target.check()?;
    let size = outline(target)?.size_mm();
    let fits = |page_mm| {
        let room = Frame::new(page_mm).area.size_mm();
        size[0] <= room[0] && size[1] <= room[1]
    };
    Ok(fits(page.portrait_mm()) || fits(page.landscape_mm()))
}

/// The pages of a target, row by row, each upright or lying as it takes fewer of them.
///
/// # Errors
/// [`TargetError`] if the target is none, or takes too many pages.
pub fn sheets(target: &Target, page: PageSize) -> Result<Vec<Sheet>, TargetError> {
    target.check()?;
    let [wide, high] = outline(target)?.size_mm();
    let mut ways = [page.portrait_mm(), page.landscape_mm()];
    // The first of equals wins.
    if wide > high {
        ways.reverse();
    }
    let mut best: Option<(Frame, [Vec<f64>; 2], usize)> = None;
    for page_mm in ways {
        let frame = Frame::new(page_mm);
        let Some(grid) = grid(target, &frame)? else {
            continue;
        };
        let pages = (grid[0].len() - 1) * (grid[1].len() - 1);
        if best.as_ref().is_none_or(|(_, _, fewest)| pages < *fewest) {
            best = Some((frame, grid, pages));
        }
    }
    let (frame, [xs, ys], pages) = best.ok_or(TargetError::PageTooSmall { page })?;
    if pages > MAX_PAGES || xs.len() - 1 > MAX_SIDE || ys.len() - 1 > MAX_SIDE {
        return Err(TargetError::TooManyPages {
            pages,
            page,
            allowed: MAX_PAGES,
        });
    }
    let ink = ink(target)?;
    let (rows, columns) = (ys.len() - 1, xs.len() - 1);
    let tiles = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    Ok(tiles
        .map(|(row, column)| {
            let tile = Rect {
                min_mm: [xs[column], ys[row]],
                max_mm: [xs[column + 1], ys[row + 1]],
            };
            let label = (pages > 1).then(|| format!("{}{}", row_name(row), column + 1));
            let mut sheet = frame.sheet(&caption(target, label.as_deref(), [rows, columns]), label);
            place(&mut sheet, &frame, &ink, &tile);
            sheet
        })
        .collect())
}

fn row_name(row: usize) -> char {
    // At most MAX_SIDE rows.
    char::from(b'A' + (row % MAX_SIDE) as u8)
}

fn caption(target: &Target, label: Option<&str>, [rows, columns]: [usize; 2]) -> Vec<String> {
    let mut caption = target.words();
    caption.push("Print at 100 %, no fit to page; measure both rulers. This side up.".into());
    if let Some(label) = label {
        caption.push(format!(
            "Page {label} of A1 to {}{columns}: cut at the marks, join without overlap, letters are \
             rows.",
            row_name(rows - 1)
        ));
    }
    caption
}

/// Puts the ink inside `tile` in the middle of the page's area, with crop marks if the page is one
/// of several.
fn place(sheet: &mut Sheet, frame: &Frame, ink: &[Rect], tile: &Rect) {
    let (room, size) = (frame.area.size_mm(), tile.size_mm());
    let by = [0, 1].map(|k| frame.area.min_mm[k] + (room[k] - size[k]) / 2.0 - tile.min_mm[k]);
    let inside = ink.iter().filter_map(|rect| rect.within(tile));
    sheet.target = inside.map(|rect| rect.moved(by)).collect();
    if sheet.label.is_some() {
        sheet.marks.extend(crop_marks(&tile.moved(by)));
    }
}

/// Lines outside the corners of a tile, on its borders' extensions.
fn crop_marks(tile: &Rect) -> Vec<Rect> {
    const AWAY_MM: f64 = 0.5;
    const LENGTH_MM: f64 = 2.5;
    let mut marks = vec![];
    for axis in [0, 1] {
        let across = 1 - axis;
        for border in [tile.min_mm[across], tile.max_mm[across]] {
            for start in [
                tile.min_mm[axis] - AWAY_MM - LENGTH_MM,
                tile.max_mm[axis] + AWAY_MM,
            ] {
                let (mut at, mut size) = ([0.0; 2], [0.0; 2]);
                (at[axis], size[axis]) = (start, LENGTH_MM);
                (at[across], size[across]) = (border - LINE_MM / 2.0, LINE_MM);
                marks.push(Rect::new(at, size));
            }
        }
    }
    marks
}
