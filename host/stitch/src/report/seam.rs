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
    let [before, after] = input.similarity;
    let all = || before.iter().chain(after).filter(|dot| dot[1].is_finite());
    if all().next().is_none() {
        return String::new();
    }
    let mean = |dots: &[[f64; 2]]| {
        let sound = || dots.iter().filter(|dot| dot[1].is_finite());
        sound().map(|dot| dot[1]).sum::<f64>() / sound().count() as f64
    };
    let least = |k: usize| all().map(|dot| dot[k]).fold(f64::INFINITY, f64::min);
    let most = all().map(|dot| dot[0]).fold(f64::NEG_INFINITY, f64::max);
    let mut plot = Plot::new([1120.0, 320.0], [least(0), most], [least(1).min(0.0), 1.0]);
    plot.dots("red", before.iter().copied());
    plot.dots("seen", after.iter().copied());
    captioned(
        &plot.finish(
            "Similarity along the cut",
            "degrees around the eyes' axis",
            "SSIM",
        ),
        &format!(
            "Structural similarity of the eyes along the cut: red before local alignment (mean {}), \
             blue after it ({}).",
            figure(mean(before), 3),
            figure(mean(after), 3)
        ),
    )
}
