//! Sections: models tried, and the parameters of the one chosen.

use super::facts::Facts;
use tectum_page::svg::{escape, figure};

pub fn html(facts: &Facts) -> String {
    format!("{}{}", scores(facts), parameters(facts))
}

fn scores(facts: &Facts) -> String {
    let chosen = facts.chosen();
    let rows = facts.input.calibration.scores.iter().map(|score| {
        let ours = chosen.is_some_and(|c| std::ptr::eq(c, score));
        let (class, mark) = match (ours, &score.failure) {
            (true, _) => (" class=\"chosen\"", "chosen".into()),
            (_, Some(why)) => (" class=\"failed\"", escape(why)),
            _ => ("", String::new()),
        };
        format!(
            "<tr{class}><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td>{mark}</td></tr>\n",
            escape(&score.name),
            score.parameters,
            figure(score.rms_px, 4),
            figure(score.held_out_rms_px.unwrap_or(f64::NAN), 4),
        )
    });
    let rows: String = rows.collect();
    let sound = facts
        .input
        .calibration
        .scores
        .iter()
        .filter(|score| score.failure.is_none());
    let held_out = sound.filter_map(|score| Some((score, score.held_out_rms_px?)));
    let best = held_out
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(score, rms_px)| {
            let name = escape(&score.name);
            format!(
                " The lowest held-out figure is that of {name}, {} px.",
                figure(rms_px, 4)
            )
        });
    let best = best.unwrap_or_default();
    format!(
        "<section id=\"models\"><h2>Models tried</h2>\n<div class=\"wide\"><table>\
         <tr><th>model</th><th class=\"n\">parameters</th><th class=\"n\">own pictures, px</th>\
         <th class=\"n\">held out, px</th><th></th></tr>\n{rows}</table></div>\
         <p class=\"dim\">2-D RMS over the same corners. Held out: the lens from the other \
         pictures, the pose alone refitted. Chosen is the simplest of its kind that the best of \
         them beats by no more than chance: a higher degree always fits its own pictures \
         better.{best}</p></section>\n"
    )
}

fn parameters(facts: &Facts) -> String {
    let rows = facts.input.calibration.parameters.iter().map(|parameter| {
        let [value, error] = with_error(parameter.value, parameter.standard_error);
        let share = (parameter.standard_error / parameter.value).abs() * 100.0;
        // Two digits; a parameter that is all error needs none.
        let decimals = (1.0 - libm::floor(libm::log10(share))).clamp(0.0, 8.0) as usize;
        let share = if share < 1e3 {
            figure(share, decimals) + " %"
        } else {
            "–".into()
        };
        format!(
            "<tr><td>{}</td><td class=\"n\">{value}</td><td class=\"n\">{error}</td>\
             <td class=\"n dim\">{share}</td></tr>\n",
            escape(&parameter.name)
        )
    });
    let rows: String = rows.collect();
    let board = match &facts.input.calibration.board_shape {
        Some(shape) => format!(
            " The board is {shape}: pictures held out are explained better so, and every picture is \
             judged with that board."
        ),
        None => " No bend of the board that all pictures share shows on pictures held out.".into(),
    };
    format!(
        "<section id=\"parameters\"><h2>Parameters</h2>\n<div class=\"wide\"><table>\
         <tr><th>parameter</th><th class=\"n\">estimate</th><th class=\"n\">standard error</th>\
         <th class=\"n\">relative</th></tr>\n{rows}</table></div><p class=\"dim\">One sigma, poses \
         marginalised. Coefficients of a polynomial depend on each other: what counts is the \
         uncertainty of directions above.{board}</p></section>\n"
    )
}

/// A value and its error, both to the error's second digit.
fn with_error(value: f64, error: f64) -> [String; 2] {
    if value == 0.0 {
        return [
            "0".into(),
            if error.is_finite() {
                format!("{error:.1e}")
            } else {
                "–".into()
            },
        ];
    }
    if !(error.is_finite() && error > 0.0) {
        return [figure(value, 6), "–".into()];
    }
    let digit = libm::floor(libm::log10(error)) as i32;
    if value.is_finite() && (value.abs() < 1e-2 || digit > 5) {
        let lead = libm::floor(libm::log10(value.abs().max(error))) as i32;
        let decimals = (lead - digit + 1).clamp(1, 15) as usize;
        return [format!("{value:.decimals$e}"), format!("{error:.1e}")];
    }
    let decimals = (1 - digit).clamp(0, 15) as usize;
    [figure(value, decimals), figure(error, decimals)]
}

#[cfg(test)]
mod tests {
    use super::with_error;

    #[test]
    fn values_stop_where_their_error_begins() {
        assert_eq!(with_error(639.512345, 0.0321), ["639.512", "0.032"]);
        assert_eq!(
            with_error(-1.234_567e-9, 2.5e-12),
            ["-1.2346e-9", "2.5e-12"]
        );
        assert_eq!(with_error(12.0, f64::NAN), ["12.000000", "–"]);
        assert_eq!(with_error(f64::NAN, 1.0), ["–", "1.0"]);
        assert_eq!(with_error(0.0, 1e-5), ["0", "1.0e-5"]);
    }
}
