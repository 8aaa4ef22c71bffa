//! Which pictures of a board are worth keeping.

/// Cells along each side of a picture: a cell of a 1280 px picture is some 100 px, a board held at
/// arm's length covers five to twenty.
const CELLS: usize = 12;
/// Cells that a picture must add.
const LEAST_NEW: usize = 2;
/// Share of the board's cells that must be new, one in so many.
const NEW_SHARE: usize = 5;
/// A board that moves by more from one look to the next, as a share of the picture's width, is
/// blurred or read out bent.
const STEADY_SHARE: f64 = 0.015;

/// Parts of a picture where corners of a board have been.
#[derive(Debug, Clone)]
pub struct Coverage {
    size_px: [u16; 2],
    seen: Vec<bool>,
}

impl Coverage {
    /// Nothing covered of a picture of this size.
    pub fn new(size_px: [u16; 2]) -> Self {
        Self {
            size_px,
            seen: vec![false; CELLS * CELLS],
        }
    }

    /// Cells along each side.
    pub const fn side() -> usize {
        CELLS
    }

    /// Whether each cell is covered, row by row.
    pub fn cells(&self) -> &[bool] {
        &self.seen
    }

    /// Number of cells covered.
    pub fn covered(&self) -> usize {
        self.seen.iter().filter(|seen| **seen).count()
    }

    /// Takes corners in, px.
    pub fn add(&mut self, corners_px: &[[f64; 2]]) {
        for cell in self.touched(corners_px) {
            self.seen[cell] = true;
        }
    }

    /// Whether corners cover enough that is new.
    fn gains(&self, corners_px: &[[f64; 2]]) -> bool {
        let touched = self.touched(corners_px);
        let new = touched.iter().filter(|cell| !self.seen[**cell]).count();
        new >= LEAST_NEW.max(touched.len() / NEW_SHARE)
    }

    fn touched(&self, corners_px: &[[f64; 2]]) -> Vec<usize> {
        let cell = |p: f64, side: u16| {
            let at = (p + 0.5) / f64::from(side) * CELLS as f64;
            (at.max(0.0) as usize).min(CELLS - 1)
        };
        let mut cells: Vec<usize> = corners_px
            .iter()
            .map(|[x, y]| cell(*y, self.size_px[1]) * CELLS + cell(*x, self.size_px[0]))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// What to do with a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Keep the pictures of the eyes that see the board, left and right.
    Keep([bool; 2]),
    /// The board is moving.
    Moving,
    /// The board is where it has been.
    Known,
    /// No eye sees a board.
    NoBoard,
}

/// A calibration session: keeps a shot when the board is somewhere new, for one eye or, where both
/// see it, for both together.
#[derive(Debug, Clone)]
pub struct Session {
    eyes: [Coverage; 2],
    /// Where boards have been in the left eye that the right eye saw too: poses of the eyes towards
    /// each other come from these alone.
    together: Coverage,
    before: [Option<Vec<[f64; 2]>>; 2],
    wants_steady: bool,
}

impl Session {
    /// An empty session. With `wants_steady` a board must rest from one look to the next.
    pub fn new(size_px: [u16; 2], wants_steady: bool) -> Self {
        let empty = Coverage::new(size_px);
        Self {
            eyes: [empty.clone(), empty.clone()],
            together: empty,
            before: [None, None],
            wants_steady,
        }
    }

    /// What has been covered, left and right.
    pub fn coverage(&self) -> &[Coverage; 2] {
        &self.eyes
    }

    /// Decides on a shot by the corners, px, that each eye sees, and takes it in if it is kept.
    pub fn consider(&mut self, corners_px: [Option<&[[f64; 2]]>; 2]) -> Verdict {
        let steady = self.is_steady(corners_px);
        self.before = corners_px.map(|corners| corners.map(<[_]>::to_vec));
        if corners_px == [None, None] {
            return Verdict::NoBoard;
        }
        let gains = |coverage: &Coverage, corners: Option<&[[f64; 2]]>| {
            corners.is_some_and(|corners| coverage.gains(corners))
        };
        let [left, right] = corners_px;
        let together = left.filter(|_| right.is_some());
        let is_new = gains(&self.eyes[0], left)
            || gains(&self.eyes[1], right)
            || gains(&self.together, together);
        if !is_new {
            return Verdict::Known;
        }
        if self.wants_steady && !steady {
            return Verdict::Moving;
        }
        self.take(corners_px);
        Verdict::Keep(corners_px.map(|corners| corners.is_some()))
    }

    /// Takes in what an earlier run kept.
    pub fn take(&mut self, corners_px: [Option<&[[f64; 2]]>; 2]) {
        for (eye, corners) in self.eyes.iter_mut().zip(corners_px) {
            eye.add(corners.unwrap_or_default());
        }
        if let [Some(left), Some(_)] = corners_px {
            self.together.add(left);
        }
    }

    /// Whether the board rests, in every eye that sees it. Labels may begin anywhere from look to
    /// look, so the middle of the corners is compared.
    fn is_steady(&self, corners_px: [Option<&[[f64; 2]]>; 2]) -> bool {
        let limit_px = STEADY_SHARE * f64::from(self.eyes[0].size_px[0]);
        let eyes = corners_px.iter().zip(&self.before);
        eyes.filter_map(|(now, before)| Some(((*now)?, before)))
            .all(|(now, before)| {
                before.as_ref().is_some_and(|before| {
                    let ([x0, y0], [x1, y1]) = (middle(before), middle(now));
                    (x1 - x0).hypot(y1 - y0) <= limit_px
                })
            })
    }
}

fn middle(corners: &[[f64; 2]]) -> [f64; 2] {
    let count = corners.len().max(1) as f64;
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board of 4x4 corners, 40 px apart.
    fn board(x: f64, y: f64) -> Vec<[f64; 2]> {
        (0..16)
            .map(|i| [x + f64::from(i % 4) * 40.0, y + f64::from(i / 4) * 40.0])
            .collect()
    }

    #[test]
    fn a_shot_is_kept_where_the_board_is_new_and_rests() {
        let mut session = Session::new([480, 480], true);
        let here = board(100.0, 100.0);
        assert_eq!(session.consider([None, None]), Verdict::NoBoard);
        assert_eq!(session.consider([Some(&here), None]), Verdict::Moving);
        let keep = Verdict::Keep([true, false]);
        assert_eq!(session.consider([Some(&here), None]), keep);
        assert_eq!(session.consider([Some(&here), None]), Verdict::Known);
        let there = board(300.0, 100.0);
        assert_eq!(session.consider([Some(&there), None]), Verdict::Moving);
        assert_eq!(session.consider([Some(&there), None]), keep);
        assert!(session.coverage()[0].covered() > 16);
        assert_eq!(session.coverage()[1].covered(), 0);
    }

    #[test]
    fn both_eyes_together_are_worth_a_shot_of_their_own() {
        let mut session = Session::new([480, 480], false);
        let (left, right) = (board(100.0, 100.0), board(20.0, 90.0));
        session.take([Some(&left), None]);
        session.take([None, Some(&right)]);
        let both = [Some(&*left), Some(&*right)];
        assert_eq!(session.consider(both), Verdict::Keep([true, true]));
        assert_eq!(session.consider(both), Verdict::Known);
    }

    #[test]
    fn corners_on_and_beyond_the_edge_are_in_the_outermost_cells() {
        let mut coverage = Coverage::new([480, 240]);
        coverage.add(&[[-3.0, -0.5], [479.4, 239.9], [1e9, 0.0]]);
        assert_eq!(coverage.covered(), 3);
        assert!(coverage.cells()[0] && coverage.cells()[CELLS * CELLS - 1]);
    }
}
