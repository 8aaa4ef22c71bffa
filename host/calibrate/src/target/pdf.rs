//! Sheets as PDF.

use pdf_writer::{Content, Finish, Name, Pdf, Rect as Box, Ref, Str};

use super::sheet::Sheet;

/// Points (1/72 inch) in a mm.
const POINTS_PER_MM: f64 = 72.0 / 25.4;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const FONT: Ref = Ref::new(3);
const FONT_NAME: Name<'static> = Name(b"F");

/// Pages as one PDF. It asks the print dialogue not to scale.
pub fn pdf(sheets: &[Sheet]) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let mut catalog = pdf.catalog(CATALOG);
    catalog.pages(PAGES);
    catalog
        .viewer_preferences()
        .pair(Name(b"PrintScaling"), Name(b"None"));
    catalog.finish();
    // At most some thousand pages, two objects each.
    let page_ref = |k: usize| Ref::new(4 + 2 * k as i32);
    pdf.pages(PAGES)
        .kids((0..sheets.len()).map(page_ref))
        .count(sheets.len() as i32);
    // One of the fonts that every reader has: nothing to embed.
    pdf.type1_font(FONT).base_font(Name(b"Helvetica"));
    for (k, sheet) in sheets.iter().enumerate() {
        let (id, content) = (page_ref(k), Ref::new(page_ref(k).get() + 1));
        let [width, height] = sheet.size_mm.map(|mm| (mm * POINTS_PER_MM) as f32);
        let mut page = pdf.page(id);
        page.parent(PAGES)
            .media_box(Box::new(0.0, 0.0, width, height))
            .contents(content);
        page.resources().fonts().pair(FONT_NAME, FONT);
        page.finish();
        pdf.stream(content, &drawn(sheet, height));
    }
    pdf.finish()
}

/// Content of a page `height_pt` high, drawn in mm with y down.
fn drawn(sheet: &Sheet, height_pt: f32) -> Vec<u8> {
    let scale = POINTS_PER_MM as f32;
    let mut content = Content::new();
    content.transform([scale, 0.0, 0.0, -scale, 0.0, height_pt]);
    for rects in [&sheet.target, &sheet.marks] {
        for rect in rects {
            let ([x, y], [w, h]) = (
                rect.min_mm.map(|mm| mm as f32),
                rect.size_mm().map(|mm| mm as f32),
            );
            content.rect(x, y, w, h);
        }
        // One path: neighbours in separate shapes would show a hairline between them.
        content.fill_nonzero();
    }
    content.begin_text();
    for line in &sheet.texts {
        let ([x, y], em) = (line.at_mm.map(|mm| mm as f32), line.em_mm as f32);
        content
            .set_font(FONT_NAME, 1.0)
            .set_text_matrix([em, 0.0, 0.0, -em, x, y])
            .show(Str(line.text.as_bytes()));
    }
    content.end_text();
    content.finish().to_vec()
}
