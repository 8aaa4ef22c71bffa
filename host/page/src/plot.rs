//! A plot with two linear axes.

use super::svg::{Path, drawing, text};

const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 48.0;

/// A plot under construction.
#[derive(Debug)]
pub struct Plot {
    size: [f64; 2],
    x: [f64; 2],
    y: [f64; 2],
    body: String,
}

impl Plot {
    /// A plot of a size in user units over ranges of x and y. An empty range, or one that is not
    /// finite, becomes 0 to 1.
    pub fn new(size: [f64; 2], x: [f64; 2], y: [f64; 2]) -> Self {
        let sound = |[low, high]: [f64; 2]| match high > low && (high - low).is_finite() {
            true => [low, high],
            false => [0.0, 1.0],
        };
        Self {
            size,
            x: sound(x),
            y: sound(y),
            body: String::new(),
        }
    }

    /// Size of what the axes of a plot of a size enclose, user units.
    pub fn inner([width, height]: [f64; 2]) -> [f64; 2] {
        [width - LEFT - RIGHT, height - TOP - BOTTOM]
    }

    /// Where a point lies in the drawing.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let [width, height] = Self::inner(self.size);
        [
            LEFT + share(x, self.x) * width,
            TOP + (1.0 - share(y, self.y)) * height,
        ]
    }

    /// A line through points.
    pub fn line(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let points: Vec<_> = points.into_iter().map(|point| self.at(point)).collect();
        self.body += &Path::through(points).element(class);
    }

    /// Dots at points; those outside the range are drawn on its edge.
    pub fn dots(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let held = |[x, y]: [f64; 2]| self.at([x, y.clamp(self.y[0], self.y[1])]);
        let points: Vec<_> = points.into_iter().map(held).collect();
        self.body += &Path::dots(points).element(class);
    }

    /// A rectangle between two corners, with words that show when pointed at.
    pub fn bar(&mut self, class: &str, low: [f64; 2], high: [f64; 2], words: &str) {
        let ([x0, y1], [x1, y0]) = (self.at(low), self.at(high));
        if [x0, y0, x1, y1].iter().all(|v| v.is_finite()) {
            self.body += &format!(
                "<rect class=\"{class}\" x=\"{x0:.1}\" y=\"{y0:.1}\" width=\"{:.1}\" \
                 height=\"{:.1}\"><title>{words}</title></rect>",
                (x1 - x0).max(0.0),
                (y1 - y0).max(0.0)
            );
        }
    }

    /// Words at a point.
    pub fn label(&mut self, class: &str, point: [f64; 2], words: &str) {
        let at = self.at(point);
        if at.iter().all(|v| v.is_finite()) {
            self.body += &text(class, at, words);
        }
    }

    /// The finished drawing, with its axes named.
    pub fn finish(self, label: &str, x_name: &str, y_name: &str) -> String {
        let mut frame = String::new();
        let [x0, y0] = self.at([self.x[0], self.y[0]]);
        let [x1, y1] = self.at([self.x[1], self.y[1]]);
        for tick in ticks(self.x, 7) {
            let [x, _] = self.at([tick, 0.0]);
            frame += &Path::through([[x, y0], [x, y1]]).element("grid");
            frame += &text("mid", [x, y0 + 18.0], &short(tick, self.x));
        }
        for tick in ticks(self.y, 5) {
            let [_, y] = self.at([0.0, tick]);
            frame += &Path::through([[x0, y], [x1, y]]).element("grid");
            frame += &text("end", [x0 - 7.0, y + 4.5], &short(tick, self.y));
        }
        let names = [
            text("mid name", [(x0 + x1) / 2.0, self.size[1] - 8.0], x_name),
            format!(
                "<text class=\"mid name\" transform=\"translate(15 {:.0}) rotate(-90)\">\
                 {y_name}</text>",
                (y0 + y1) / 2.0
            ),
        ];
        drawing(self.size, label, &(frame + &self.body + &names.concat()))
    }
}

/// Round steps (1, 2, 3 or 5 times a power of ten) over a range, at most about `count`.
pub fn ticks([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let step = step((high - low) / count as f64);
    let first = libm::ceil(low / step - 1e-9);
    (0..=2 * count)
        .map(|i| (first + i as f64) * step)
        .take_while(|tick| *tick <= high + step * 1e-9)
        .collect()
}

/// The round step at or above a width.
pub fn step(width: f64) -> f64 {
    if !(width > 0.0 && width.is_finite()) {
        return 1.0;
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(width)));
    let sound = [1.0, 2.0, 3.0, 5.0, 10.0].into_iter().map(|m| m * power);
    sound
        .into_iter()
        .find(|step| *step >= width * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// A tick's figure with the decimals that its range needs.
fn short(tick: f64, [low, high]: [f64; 2]) -> String {
    let width = (high - low) / 7.0;
    let decimals = (-libm::floor(libm::log10(width))).clamp(0.0, 6.0);
    let text = format!("{tick:.*}", decimals as usize);
    if text.trim_matches(['-', '0', '.']).is_empty() {
        "0".into()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks([0.0, 105.0], 7), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        let small = ticks([-0.31, 0.29], 5);
        assert_eq!(small.len(), 3);
        // Products of two decimals: a unit in the last place.
        assert!(
            small
                .iter()
                .zip([-0.2, 0.0, 0.2])
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
    }

    #[test]
    fn odd_ranges_draw_an_empty_plot() {
        for range in [[0.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            let mut plot = Plot::new([300.0, 200.0], range, range);
            plot.dots("d", [[0.5, f64::NAN], [0.2, 0.4]]);
            let drawn = plot.finish("empty", "x", "y");
            assert!(drawn.contains(">0<") && !drawn.contains("NaN") && !drawn.contains("inf"));
        }
    }
}
