//! Sub-pixel corner: a model of the crossing fitted to the picture.
//!
//! Around an inner corner the picture is modelled as
//! `a + g.q + h T(E(d1 / w1) E(d2 / w2))`, `q` the place relative to the corner: two edges blurred by
//! Gaussians (`E(x) = erf(x / sqrt 2)`), each a parabola `d = n.q + k (t.q)^2 / 2` because lenses
//! bend lines, a tone curve `T(p) = p + b (1 - p^2)` because bright squares bloom and gamma bends
//! tones, on a tilted ground. Where glare parts the dark squares, the product is that of two dark
//! squares whose edges lie `s` px further in (`d - s` on one side of an edge, `d + s` on the other).
//! All parameters are fitted by Levenberg-Marquardt. The model is point symmetric about the corner, so
//! that what moves both edges of a square alike does not move the corner.

use nalgebra::{SMatrix, SVector};

use super::super::normal::normal;
use super::plane::Plane;

const PARAMETERS: usize = 14;
const STEPS: usize = 30;
/// Steps shorter than this move no corner that matters, px.
const SHORT_PX: f64 = 1e-4;
/// Grey levels of noise against which the weak priors are weighed.
const NOISE: f64 = 6.0;

/// A corner's model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Saddle {
    /// Corner, px.
    pub at: [f64; 2],
    /// Directions of both edges, rad from +x towards +y.
    pub edges_rad: [f64; 2],
    /// Curvature of both edges, 1/px.
    curvatures: [f64; 2],
    /// Logarithm of the blur of both edges, sigma in px.
    log_blurs: [f64; 2],
    ground: f64,
    tilt: [f64; 2],
    /// Half the step between dark and bright; positive where the sector between the first edge
    /// and the second (turning from +x to +y, first less than second) is **dark**.
    pub contrast: f64,
    /// Share by which tones between dark and bright are brighter than their mean: saturation.
    tone: f64,
    /// How far glare reaches over the edges of dark squares, px.
    glare_px: f64,
    /// Whether there may be glare; it is 0 otherwise.
    pub in_glare: bool,
}

/// A fitted corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub saddle: Saddle,
    /// RMS of the picture beside the model, grey levels, weighted as in the fit.
    pub residual: f64,
    /// Standard error of a coordinate from the picture's noise, px.
    pub sigma_px: f64,
    /// The darker bright square less the brighter dark one, beside the contrast: about 1 at an
    /// inner corner, 0 or less where only one square or one edge is dark.
    pub separation: f64,
}

impl Saddle {
    /// A start for the fit.
    pub fn start(at: [f64; 2], edges_rad: [f64; 2], blur_px: f64) -> Self {
        Self {
            at,
            edges_rad,
            curvatures: [0.0; 2],
            log_blurs: [libm::log(blur_px); 2],
            ground: 0.0,
            tilt: [0.0; 2],
            contrast: 0.0,
            tone: 0.0,
            glare_px: 0.0,
            in_glare: false,
        }
    }

    /// Blur of both edges, sigma in px.
    pub fn blurs_px(&self) -> [f64; 2] {
        self.log_blurs.map(libm::exp)
    }

    fn to_vector(self) -> SVector<f64, PARAMETERS> {
        SVector::from([
            self.at[0],
            self.at[1],
            self.edges_rad[0],
            self.edges_rad[1],
            self.curvatures[0],
            self.curvatures[1],
            self.log_blurs[0],
            self.log_blurs[1],
            self.ground,
            self.tilt[0],
            self.tilt[1],
            self.contrast,
            self.tone,
            self.glare_px,
        ])
    }

    /// Less a step of the fit.
    fn moved(self, step: &SVector<f64, PARAMETERS>) -> Self {
        let v = self.to_vector() - step;
        Self {
            at: [v[0], v[1]],
            edges_rad: [v[2], v[3]],
            curvatures: [v[4], v[5]],
            log_blurs: [v[6], v[7]],
            ground: v[8],
            tilt: [v[9], v[10]],
            contrast: v[11],
            tone: v[12],
            glare_px: v[13],
            in_glare: self.in_glare,
        }
    }

    /// Signed distance of `q` from edge `k`, px.
    fn distance_px(&self, k: usize, q: [f64; 2], frames: &[[f64; 2]; 2]) -> f64 {
        let [cos, sin] = frames[k];
        let along = cos * q[0] + sin * q[1];
        cos * q[1] - sin * q[0] + self.curvatures[k] * along * along / 2.0
    }

    /// Model at `q` from the corner, and its derivatives.
    fn evaluate(
        &self,
        q: [f64; 2],
        Fixed { frames, blurs_px }: &Fixed,
    ) -> (f64, [f64; PARAMETERS]) {
        // Shares of the half planes on either side of an edge, after and before it, and their slopes by
        // the distance into them; then the distance's derivatives by the corner, the direction and the
        // curvature; the half planes' by the blur.
        let mut half = [[0.0; 2]; 2];
        let mut slope = [[0.0; 2]; 2];
        let mut by_at = [[0.0; 2]; 2];
        let mut by_edge = [0.0; 2];
        let mut by_curvature = [0.0; 2];
        let mut by_blur = [[0.0; 2]; 2];
        for k in 0..2 {
            let [cos, sin] = frames[k];
            let along = cos * q[0] + sin * q[1];
            let across = cos * q[1] - sin * q[0];
            let bend = self.curvatures[k] * along;
            let d = across + bend * along / 2.0;
            let blur = blurs_px[k];
            (half[k][0], slope[k][0]) = normal((d - self.glare_px) / blur).into();
            (half[k][1], slope[k][1]) = if self.in_glare {
                normal((-d - self.glare_px) / blur).into()
            } else {
                (1.0 - half[k][0], slope[k][0])
            };
            slope[k] = slope[k].map(|slope| slope / blur);
            by_at[k] = [sin - bend * cos, -cos - bend * sin];
            by_edge[k] = -along + bend * across;
            by_curvature[k] = along * along / 2.0;
            by_blur[k] = [
                slope[k][0] * (self.glare_px - d),
                slope[k][1] * (self.glare_px + d),
            ];
        }
        // The dark squares are where both edges are on sides that differ, or, where bright and dark
        // change places, that do not.
        let swapped = self.contrast < 0.0;
        let sign = if swapped { -1.0 } else { 1.0 };
        let dark = |k: usize, values: [f64; 2]| {
            let other = half[1 - k];
            let [a, b] = if swapped { other } else { [other[1], other[0]] };
            values[0] * a + values[1] * b
        };
        let product = sign * (1.0 - 2.0 * dark(0, half[0]));
        let lifted = 1.0 - product * product;
        let toned = product + self.tone * lifted;
        let value = self.ground + self.tilt[0] * q[0] + self.tilt[1] * q[1] + self.contrast * toned;
        let by_dark = -2.0 * sign * self.contrast * (1.0 - 2.0 * self.tone * product);
        let by_d = [0, 1].map(|k| by_dark * dark(k, [slope[k][0], -slope[k][1]]));
        let by_blur = [0, 1].map(|k| by_dark * dark(k, by_blur[k]));
        let by_glare = match self.in_glare {
            true => -by_dark * (dark(0, slope[0]) + dark(1, slope[1])),
            false => 0.0,
        };
        let by_centre =
            |axis: usize| by_d[0] * by_at[0][axis] + by_d[1] * by_at[1][axis] - self.tilt[axis];
        let derivatives = [
            by_centre(0),
            by_centre(1),
            by_d[0] * by_edge[0],
            by_d[1] * by_edge[1],
            by_d[0] * by_curvature[0],
            by_d[1] * by_curvature[1],
            by_blur[0],
            by_blur[1],
            1.0,
            q[0],
            q[1],
            toned,
            self.contrast * lifted,
            by_glare,
        ];
        (value, derivatives)
    }
}

/// Beyond 1/2 the tone curve is no longer monotone everywhere.
const MOST_TONE: f64 = 0.6;
/// Glare reaches less than this share of the window.
const MOST_GLARE: f64 = 0.5;
/// Glare is white: grey levels that a camera clips.
const CLIPPED: f64 = 250.0;

/// What a model has in common at all pixels.
struct Fixed {
    /// Cosine and sine of both edges' directions.
    frames: [[f64; 2]; 2],
    /// [`Saddle::blurs_px`].
    blurs_px: [f64; 2],
}

impl Fixed {
    fn of(saddle: &Saddle) -> Self {
        Self {
            frames: frames(saddle),
            blurs_px: saddle.blurs_px(),
        }
    }
}

/// Corners nearer to the picture's border are not sure, px.
const MARGIN_PX: f64 = 3.0;

/// A round window with its weights.
struct Window {
    pixels: Vec<([f64; 2], f64, f64)>,
    weight: f64,
}

impl Window {
    /// All pixels within `radius_px`, less those beyond the picture's border; `None` if the corner
    /// itself is nearer to the border than any window is large.
    fn new(plane: &Plane, at: [f64; 2], radius_px: f64) -> Option<Self> {
        let centre = at.map(f64::round);
        let last = [plane.width, plane.height].map(|n| n as f64 - 1.0);
        let inside = |k: usize| (MARGIN_PX..=last[k] - MARGIN_PX).contains(&centre[k]);
        if !(inside(0) && inside(1)) {
            return None;
        }
        let reach = radius_px.floor();
        let from = centre.map(|c| (c - reach).max(0.0) as usize);
        let to = [0, 1].map(|k| (centre[k] + reach).min(last[k]) as usize);
        let mut pixels = Vec::with_capacity((to[0] + 1 - from[0]) * (to[1] + 1 - from[1]));
        let mut weight = 0.0;
        for y in from[1]..=to[1] {
            for x in from[0]..=to[0] {
                let place = [x as f64, y as f64];
                let distance2 = (place[0] - centre[0]).powi(2) + (place[1] - centre[1]).powi(2);
                let inside = 1.0 - distance2 / (radius_px * radius_px);
                if inside > 0.0 {
                    // Falls to 0 at the rim: what the model does not know grows with distance.
                    let w = inside.sqrt();
                    pixels.push((place, f64::from(plane.data[y * plane.width + x]), w));
                    weight += w;
                }
            }
        }
        Some(Self { pixels, weight })
    }
}

type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Fits a corner in a round window. `None` if the picture ends inside the window, or the fit runs
/// away.
pub(super) fn fit(plane: &Plane, start: &Saddle, radius_px: f64) -> Option<Fit> {
    let window = Window::new(plane, start.at, radius_px)?;
    let mut saddle = with_levels(start, &window);
    let priors = priors(radius_px);
    let (mut cost, mut normal, mut gradient) = linearise(&saddle, start, &window, &priors);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let mut damped = normal;
        for k in 0..PARAMETERS {
            damped[(k, k)] += damping * normal[(k, k)].max(1e-9);
        }
        let step = damped.cholesky()?.solve(&gradient);
        let next = saddle.moved(&step);
        let moved = libm::hypot(next.at[0] - start.at[0], next.at[1] - start.at[1]);
        let sound = step.iter().all(|s| s.is_finite())
            && moved < radius_px
            && next.log_blurs.iter().all(|b| (-2.0..3.0).contains(b))
            && next.tone.abs() < MOST_TONE
            && next.glare_px < MOST_GLARE * radius_px;
        let is_short = libm::hypot(step[0], step[1]) < SHORT_PX;
        let trial = sound.then(|| linearise(&next, start, &window, &priors));
        match trial {
            Some((lower, n, g)) if lower < cost => {
                let settled = is_short && cost - lower < 1e-6 * cost;
                (saddle, cost, normal, gradient) = (next, lower, n, g);
                damping = (damping / 5.0).max(1e-9);
                if settled {
                    break;
                }
            }
            // At the minimum, as far as rounding lets the cost tell.
            Some(_) if is_short => break,
            _ => {
                damping *= 8.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
    }
    // What hides a corner is no glare unless it is white.
    if saddle.in_glare && !is_white(plane, saddle.at) {
        return None;
    }
    let residual = (cost / window.weight).sqrt();
    // Half the corner's sum of variances, at the noise that the residual shows.
    let inverse = normal.cholesky()?.inverse();
    let sigma_px = residual * ((inverse[(0, 0)] + inverse[(1, 1)]) / 2.0).sqrt();
    sigma_px.is_finite().then_some(Fit {
        saddle,
        residual,
        sigma_px,
        separation: separation(&saddle, &window),
    })
}

/// Whether the picture is clipped at a place, or within a pixel of it.
fn is_white(plane: &Plane, at: [f64; 2]) -> bool {
    let around = [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    around.iter().any(|[dx, dy]| {
        let value = plane.sample([at[0] + dx, at[1] + dy]);
        value.is_some_and(|value| value >= CLIPPED)
    })
}

/// See [`Fit::separation`]; from the pixels themselves, well inside their squares. Negative
/// infinity if a square has none.
fn separation(saddle: &Saddle, window: &Window) -> f64 {
    /// This many sigmas of blur from both edges a pixel belongs to one square.
    const CLEAR: f64 = 0.8;
    let blurs = saddle.blurs_px();
    let frames = frames(saddle);
    // By the signs of the distances to both edges.
    let mut squares = [(0.0, 0.0); 4];
    for (place, value, weight) in &window.pixels {
        let q = [place[0] - saddle.at[0], place[1] - saddle.at[1]];
        let d = [0, 1].map(|k| saddle.distance_px(k, q, &frames));
        let is_dark = d[0] * d[1] * saddle.contrast < 0.0;
        let glare_px = if is_dark { saddle.glare_px } else { 0.0 };
        if (0..2).all(|k| d[k].abs() > CLEAR * blurs[k] + glare_px) {
            let square = &mut squares[usize::from(d[0] > 0.0) + 2 * usize::from(d[1] > 0.0)];
            square.0 += weight * value;
            square.1 += weight;
        }
    }
    if squares.iter().any(|(_, weight)| *weight <= 0.0) {
        return f64::NEG_INFINITY;
    }
    let mean = squares.map(|(sum, weight)| saddle.contrast.signum() * sum / weight);
    // Equal signs are high for a positive contrast.
    let (bright, dark) = (mean[0].min(mean[3]), mean[1].max(mean[2]));
    (bright - dark) / (2.0 * saddle.contrast.abs())
}

/// The start with ground and contrast from the window.
fn with_levels(start: &Saddle, window: &Window) -> Saddle {
    let mut saddle = *start;
    (saddle.ground, saddle.contrast) = (0.0, 1.0);
    let fixed = Fixed::of(&saddle);
    // Weighted regression of the picture on the bare crossing.
    let mut sums = [0.0; 4];
    for (place, value, weight) in &window.pixels {
        let q = [place[0] - saddle.at[0], place[1] - saddle.at[1]];
        let crossing = saddle.evaluate(q, &fixed).0 - saddle.tilt[0] * q[0] - saddle.tilt[1] * q[1];
        for (sum, term) in
            sums.iter_mut()
                .zip([crossing, *value, crossing * crossing, crossing * value])
        {
            *sum += weight * term;
        }
    }
    let [mean_c, mean_v, mean_cc, mean_cv] = sums.map(|sum| sum / window.weight);
    let variance = (mean_cc - mean_c * mean_c).max(1e-6);
    saddle.contrast = (mean_cv - mean_c * mean_v) / variance;
    saddle.ground = mean_v - saddle.contrast * mean_c;
    saddle
}

/// Weights of the pull of each parameter towards its start: what small windows cannot tell.
fn priors(radius_px: f64) -> [f64; PARAMETERS] {
    let weight = |sigma: f64| (NOISE / sigma).powi(2);
    let mut priors = [0.0; PARAMETERS];
    // An edge bends by about a pixel over the window at most.
    priors[4] = weight(1.0 / (radius_px * radius_px));
    priors[5] = priors[4];
    // Blur within a factor of about two of the start.
    priors[6] = weight(0.7);
    priors[7] = priors[6];
    // Light changes by some 20 levels over the window.
    priors[9] = weight(20.0 / radius_px);
    priors[10] = priors[9];
    // Half a tone curve's reach.
    priors[12] = weight(0.25);
    // Weak: what glare does, it does to many grey levels. Where there is none it only must not be 0.
    priors[13] = weight(radius_px);
    priors
}

fn frames(saddle: &Saddle) -> [[f64; 2]; 2] {
    saddle
        .edges_rad
        .map(|angle| [libm::cos(angle), libm::sin(angle)])
}

/// Cost, normal matrix and gradient.
fn linearise(
    saddle: &Saddle,
    start: &Saddle,
    window: &Window,
    priors: &[f64; PARAMETERS],
) -> (f64, Normal, SVector<f64, PARAMETERS>) {
    let fixed = Fixed::of(saddle);
    let mut cost = 0.0;
    // Whole rows, though one triangle would do: loops of a fixed length take half the time.
    let mut sums = [[0.0; PARAMETERS]; PARAMETERS];
    let mut gradient = [0.0; PARAMETERS];
    for (place, value, weight) in &window.pixels {
        let q = [place[0] - saddle.at[0], place[1] - saddle.at[1]];
        let (model, derivatives) = saddle.evaluate(q, &fixed);
        let error = model - value;
        cost += weight * error * error;
        for k in 0..PARAMETERS {
            let scaled = weight * derivatives[k];
            gradient[k] += scaled * error;
            for (sum, derivative) in sums[k].iter_mut().zip(derivatives) {
                *sum += scaled * derivative;
            }
        }
    }
    let mut normal = Normal::from_fn(|row, column| sums[row.max(column)][row.min(column)]);
    let mut gradient = SVector::from(gradient);
    let (now, then) = (saddle.to_vector(), start.to_vector());
    for k in 0..PARAMETERS {
        let off = now[k] - then[k];
        cost += priors[k] * off * off;
        gradient[k] += priors[k] * off;
        normal[(k, k)] += priors[k];
    }
    (cost, normal, gradient)
}
