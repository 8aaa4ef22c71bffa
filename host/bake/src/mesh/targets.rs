//! Exact source positions of the output pixels that one eye shows.

/// Where each output pixel of one eye looks in its source frame, px, from the camera model.
#[derive(Debug, Clone)]
pub struct Targets {
    width_px: usize,
    height_px: usize,
    positions: Vec<[f64; 2]>,
}

impl Targets {
    /// Marks a pixel that the eye does not show.
    pub const HIDDEN: [f64; 2] = [f64::NAN; 2];

    /// Targets of a `width_px` x `height_px` output from its positions, row by row;
    /// [`Targets::HIDDEN`] where there is none.
    ///
    /// # Panics
    /// If the number of positions is not `width_px * height_px`.
    pub fn new(width_px: usize, height_px: usize, positions: Vec<[f64; 2]>) -> Self {
        assert_eq!(positions.len(), width_px * height_px);
        Self {
            width_px,
            height_px,
            positions,
        }
    }

    /// Width and height of the output, px.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.height_px]
    }

    /// Position of output pixel (x, y), if shown.
    pub fn get(&self, x: usize, y: usize) -> Option<[f64; 2]> {
        let position = self.positions[y * self.width_px + x];
        (!position[0].is_nan()).then_some(position)
    }

    /// All shown pixels: x, y, position.
    pub fn shown(&self) -> impl Iterator<Item = (usize, usize, [f64; 2])> + '_ {
        let rows = self.positions.chunks_exact(self.width_px).enumerate();
        rows.flat_map(|(y, row)| {
            let shown = row.iter().enumerate().filter(|(_, p)| !p[0].is_nan());
            shown.map(move |(x, p)| (x, y, *p))
        })
    }
}
