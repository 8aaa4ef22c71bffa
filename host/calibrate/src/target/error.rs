//! Why there is no target.

use std::ops::RangeInclusive;

use super::PageSize;

/// Why a target is not printed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// A number outside its range.
    #[error("{what}: {value} is not allowed, needed is {} to {}", allowed.start(), allowed.end())]
    OutOfRange {
        /// Which number, with its unit.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: RangeInclusive<f64>,
    },
    /// No such dictionary of markers.
    #[error("there is no dictionary \"{name}\"; there are {}", super::dictionary_names().join(", "))]
    NoDictionary {
        /// What was asked for.
        name: String,
    },
    /// No such marker.
    #[error("{dictionary} has no id {id}: its ids are 0 to {last}")]
    NoId {
        /// Dictionary.
        dictionary: String,
        /// What was asked for.
        id: u32,
        /// The last id.
        last: usize,
    },
    /// The marker reaches into the board or into the white that both need.
    #[error(
        "the marker lies {gap_mm:.2} mm from the board: needed is {needed_mm:.2} mm of white, or the \
         marker is not found"
    )]
    TooNear {
        /// White between marker and board, mm; negative where they overlap.
        gap_mm: f64,
        /// White needed, mm.
        needed_mm: f64,
    },
    /// Not a page.
    #[error(
        "\"{text}\" is no page: needed is a4, a3, a2, a1, a0, letter, tabloid or WIDTHxHEIGHT in mm, \
         such as 300x450, each {} to {}",
        PageSize::SIDE_MM.start(),
        PageSize::SIDE_MM.end()
    )]
    NoPage {
        /// What was asked for.
        text: String,
    },
    /// Even the smallest target is larger than a page.
    #[error("not even the smallest such target fits one page of {page}: take a larger page")]
    DoesNotFit {
        /// Page.
        page: PageSize,
    },
    /// Too many pages.
    #[error("it would take {pages} pages of {page}, allowed are {allowed}: take a larger page")]
    TooManyPages {
        /// Pages needed.
        pages: usize,
        /// Page.
        page: PageSize,
        /// Most pages.
        allowed: usize,
    },
    /// A single square or module is larger than a page.
    #[error("one square or module is larger than a page of {page}: take a larger page")]
    PageTooSmall {
        /// Page.
        page: PageSize,
    },
    /// Too many pixels.
    #[error(
        "the picture would have {width}x{height} px, allowed are {allowed} px in all: lower the dpi, \
         or write SVG or PDF"
    )]
    TooManyPixels {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
        /// Most pixels.
        allowed: u64,
    },
    /// The PNG encoder refused.
    #[error("the PNG cannot be encoded: {message}")]
    Png {
        /// What it said.
        message: String,
    },
    /// Not a file that describes targets.
    #[error("not a description of targets: {message}")]
    Syntax {
        /// What the reader said.
        message: String,
    },
}

impl TargetError {
    /// Refuses a number that is not finite or lies outside a range.
    pub(super) fn check(
        what: &'static str,
        value: f64,
        allowed: RangeInclusive<f64>,
    ) -> Result<(), Self> {
        if allowed.contains(&value) {
            return Ok(());
        }
        Err(Self::OutOfRange {
            what,
            value,
            allowed,
        })
    }
}
