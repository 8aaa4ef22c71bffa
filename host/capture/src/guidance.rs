//! What to tell the person who holds the board of a calibration session.

use crate::{Coverage, Session, Verdict};

/// A cell whose mean grey value was never above this shows nothing: outside the lens's circle.
const LIT: u32 = 24;
/// A field is covered when so many of a hundred of its cells are: the outermost cannot hold corners.
const ENOUGH_PERCENT: usize = 85;
/// Pixels of a cell that are looked at, along each side.
const SAMPLES: usize = 8;

/// Learns what part of each eye's picture the lens fills, and says where the board is wanted.
#[derive(Debug, Clone)]
pub struct Guidance {
    lit: [Vec<bool>; 2],
}

/// What the person should do next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Advice {
    /// One sentence.
    pub instruction: String,
    /// Cells of each eye, left and right, in which the board has not been, by number from row to
    /// row.
    pub wanted: [Vec<usize>; 2],
}

impl Default for Guidance {
    fn default() -> Self {
        let nothing = vec![false; Coverage::side() * Coverage::side()];
        Self {
            lit: [nothing.clone(), nothing],
        }
    }
}

impl Guidance {
    /// Takes a grey picture of an eye (0 left, 1 right) in, rows tightly packed.
    pub fn see(&mut self, eye: usize, size_px: [u16; 2], grey: &[u8]) {
        let side = Coverage::side();
        let [width, height] = size_px.map(usize::from);
        if grey.len() < width * height || eye > 1 {
            return;
        }
        for (cell, lit) in self.lit[eye].iter_mut().enumerate() {
            let at = |cell: usize, sample: usize, length: usize| {
                (cell * SAMPLES + sample) * length / (side * SAMPLES)
            };
            let sum: u32 = (0..SAMPLES * SAMPLES)
                .map(|i| {
                    let x = at(cell % side, i % SAMPLES, width);
                    let y = at(cell / side, i / SAMPLES, height);
                    u32::from(grey[y * width + x])
                })
                .sum();
            *lit |= sum > LIT * (SAMPLES * SAMPLES) as u32;
        }
    }

    /// What to do after a verdict. An eye that has shown nothing yet wants nothing.
    pub fn advise(&self, session: &Session, verdict: Verdict) -> Advice {
        let wanted = [0, 1].map(|eye| self.wanted(session, eye));
        // The eye that lacks most, for its size.
        let share = |eye: usize| {
            let lit = self.lit[eye].iter().filter(|lit| **lit).count();
            100 * wanted[eye].len() / lit.max(1)
        };
        let eye = if share(0) >= share(1) { 0 } else { 1 };
        let is_enough = share(eye) <= 100 - ENOUGH_PERCENT;
        let goal = farthest(session.coverage()[eye].cells(), &wanted[eye]).map(|cell| {
            let side = ["left", "right"][eye];
            format!("{} of the {side} eye's picture", place(cell))
        });
        let instruction = match (verdict, goal) {
            (Verdict::Moving, _) => "Hold the board still.".to_owned(),
            (_, Some(_)) if is_enough => {
                "Enough: the board has been everywhere. End with Ctrl-C.".to_owned()
            }
            (Verdict::Keep(_), Some(goal)) => format!("Kept. Next: to the {goal}."),
            (Verdict::Known, Some(goal)) => format!("Move the board to the {goal}."),
            (Verdict::NoBoard, Some(goal)) => format!("Show the whole board, at the {goal}."),
            (_, None) => "Show the whole board.".to_owned(),
        };
        Advice {
            instruction,
            wanted,
        }
    }

    fn wanted(&self, session: &Session, eye: usize) -> Vec<usize> {
        let covered = session.coverage()[eye].cells();
        let cells = self.lit[eye].iter().zip(covered).enumerate();
        cells
            .filter(|(_, (lit, covered))| **lit && !**covered)
            .map(|(cell, _)| cell)
            .collect()
    }
}

/// The wanted cell that is farthest from all covered ones; the nearest to the middle of equals.
fn farthest(covered: &[bool], wanted: &[usize]) -> Option<usize> {
    let side = Coverage::side() as i64;
    let at = |cell: usize| [cell as i64 % side, cell as i64 / side];
    let square = |a: [i64; 2], b: [i64; 2]| (a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2);
    let centre = [side / 2, side / 2];
    wanted.iter().copied().max_by_key(|cell| {
        let been = covered.iter().enumerate().filter(|(_, covered)| **covered);
        let nearest = been.map(|(other, _)| square(at(*cell), at(other))).min();
        (nearest, -square(at(*cell), centre))
    })
}

/// Where a cell is, in words.
fn place(cell: usize) -> &'static str {
    let third = |i: usize| i * 3 / Coverage::side();
    let [column, row] = [cell % Coverage::side(), cell / Coverage::side()].map(third);
    [
        ["upper left", "top", "upper right"],
        ["left border", "middle", "right border"],
        ["lower left", "bottom", "lower right"],
    ][row][column]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE_PX: [u16; 2] = [240, 240];

    /// A bright circle on black.
    fn fisheye() -> Vec<u8> {
        let inside = |i: i32| (i % 240 - 120).pow(2) + (i / 240 - 120).pow(2) < 118 * 118;
        (0..240 * 240)
            .map(|i| if inside(i) { 120 } else { 3 })
            .collect()
    }

    #[test]
    fn the_board_is_wanted_where_the_lens_shows_something_and_it_has_not_been() {
        let mut guidance = Guidance::default();
        let mut session = Session::new(SIZE_PX, false);
        let advice = guidance.advise(&session, Verdict::NoBoard);
        assert_eq!(advice.instruction, "Show the whole board.");
        guidance.see(0, SIZE_PX, &fisheye());
        let advice = guidance.advise(&session, Verdict::NoBoard);
        let begin = "Show the whole board, at the middle of the left eye's picture.";
        assert_eq!(advice.instruction, begin);
        // The corners of the picture are dark, and there is no right eye.
        assert!(!advice.wanted[0].contains(&0) && advice.wanted[0].contains(&78));
        assert!(advice.wanted[1].is_empty());
        // All but the upper left.
        let been: Vec<_> = (0..144)
            .map(|i| {
                [
                    f64::from(i % 12) * 20.0 + 9.0,
                    f64::from(i / 12) * 20.0 + 9.0,
                ]
            })
            .filter(|[x, y]| x + y > 160.0)
            .collect();
        session.take([Some(&been), None]);
        let advice = guidance.advise(&session, Verdict::Known);
        let go = "Move the board to the upper left of the left eye's picture.";
        assert_eq!(advice.instruction, go);
        let moving = guidance.advise(&session, Verdict::Moving);
        assert_eq!(moving.instruction, "Hold the board still.");
        let rest: Vec<_> = advice.wanted[0]
            .iter()
            .map(|cell| {
                [
                    (cell % 12) as f64 * 20.0 + 9.0,
                    (cell / 12) as f64 * 20.0 + 9.0,
                ]
            })
            .skip(1)
            .collect();
        session.take([Some(&rest), None]);
        let enough = guidance.advise(&session, Verdict::Known).instruction;
        assert!(enough.starts_with("Enough"), "{enough}");
    }

    #[test]
    fn a_picture_that_is_too_short_is_passed_over() {
        let mut guidance = Guidance::default();
        guidance.see(0, SIZE_PX, &[255; 10]);
        assert!(guidance.wanted(&Session::new(SIZE_PX, false), 0).is_empty());
    }
}
