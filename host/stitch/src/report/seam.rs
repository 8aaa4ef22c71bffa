//! The cut on its energy, and how alike the eyes are along it.

use tectum_page::picture::jpeg_uri;
use tectum_page::plot::Plot;
use tectum_page::svg::{captioned, figure};

use super::ReportInput;

pub fn html(input: &ReportInput) -> String {
    let energy = input.energy.and_then(|picture| jpeg_uri(picture, 1200));
    let energy = energy.map(|uri| {
        captioned(
            &format!("<img src=\"{uri}\" alt=\"energy and cut\" style=\"width:100%\">"),
            "The cut on the energy of the overlap: bright is where the eyes differ.",
        )
    });
    let similarity = similarity(input);
    if energy.is_none() && similarity.is_empty() {
        return String::new();
    }
    format!(
        "<h2 id=\"seam\">Seam</h2>\n{}{similarity}",
        energy.unwrap_or_default()
    )
}

fn similarity(input: &ReportInput) -> String {
    let count = input.similarity.len();
    if count == 0 {
        return String::new();
    }
    let column = |k: usize| input.similarity.iter().map(move |pair| pair[k]);
    let mean = |k: usize| column(k).sum::<f64>() / count as f64;
    let low = column(0).chain(column(1)).fold(0.0, f64::min);
    let mut plot = Plot::new([1120.0, 320.0], [0.0, count as f64], [low, 1.0]);
    for (class, k) in [("equidistant", 0), ("curve", 1)] {
        plot.line(class, column(k).enumerate().map(|(i, v)| [i as f64, v]));
    }
    captioned(
        &plot.finish("Similarity along the cut", "pixel of the cut", "SSIM"),
        &format!(
            "Structural similarity of the eyes along the cut: dashed before local alignment (mean \
             {}), full after it ({}).",
            figure(mean(0), 3),
            figure(mean(1), 3)
        ),
    )
}
