//! Who sees a direction.

/// Who sees a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Area {
    /// Neither eye.
    None,
    /// The left eye alone.
    Left,
    /// The right eye alone.
    Right,
    /// Both.
    Both,
}

impl Area {
    /// Seen by these eyes.
    pub fn of([left, right]: [bool; 2]) -> Self {
        match (left, right) {
            (false, false) => Self::None,
            (true, false) => Self::Left,
            (false, true) => Self::Right,
            (true, true) => Self::Both,
        }
    }

    /// Whether the left eye sees it.
    pub fn left(self) -> bool {
        matches!(self, Self::Left | Self::Both)
    }

    /// Whether the right eye sees it.
    pub fn right(self) -> bool {
        matches!(self, Self::Right | Self::Both)
    }

    /// Whether any eye sees it.
    pub fn seen(self) -> bool {
        self != Self::None
    }
}
