//! What one picture shows of the targets.

use image::GrayImage;
use serde::{Deserialize, Serialize};
use tectum_calibrate::detect::chessboard::detect_all;
use tectum_calibrate::detect::marker::{self, MarkerOptions, MarkerView};
use tectum_calibrate::target::{OverlapTarget, Target};
use tectum_calibrate::{Board, BoardSize, Corner, Dictionary, DictionaryError, View};

/// A board of a size in a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeenBoard {
    /// Size that was looked for.
    pub size: BoardSize,
    /// Its corners; labels as [`tectum_calibrate::detect::chessboard::detect`] gives them.
    pub view: View,
}

/// A marker in a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeenMarker {
    /// Dictionary it was read with.
    pub dictionary: String,
    /// The marker.
    pub view: MarkerView,
}

/// What one picture shows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// Boards of all sizes.
    pub boards: Vec<SeenBoard>,
    /// Markers of all dictionaries.
    pub markers: Vec<SeenMarker>,
    /// Whether more markers can be read in the mirrored picture.
    pub mirrored: bool,
}

impl Sighting {
    /// Looks for the targets' boards and markers.
    ///
    /// # Errors
    /// [`DictionaryError`] if a target's dictionary is none.
    pub fn find(picture: &GrayImage, targets: &[Target]) -> Result<Self, DictionaryError> {
        let mut sighting = Self::default();
        let mut sizes: Vec<BoardSize> = Vec::new();
        let mut dictionaries: Vec<&str> = Vec::new();
        for target in targets {
            let size = board(target).map(|board| board.size);
            sizes.extend(size.filter(|size| !sizes.contains(size)));
            let name = overlap(target).map(|target| &*target.dictionary);
            dictionaries.extend(name.filter(|name| !dictionaries.contains(name)));
        }
        for size in sizes {
            let views = detect_all(picture, size).into_iter();
            let seen = views.map(|view| SeenBoard { size, view });
            sighting.boards.extend(seen);
        }
        for name in dictionaries {
            let dictionary: Dictionary = name.parse()?;
            let options = MarkerOptions::default();
            let found = marker::detect(picture, &dictionary, &options);
            if found.is_empty() {
                sighting.mirrored |= marker::is_mirrored(picture, &dictionary, &options);
            }
            let seen = found.into_iter().map(|view| SeenMarker {
                dictionary: name.to_owned(),
                view,
            });
            sighting.markers.extend(seen);
        }
        Ok(sighting)
    }

    /// What the picture `width_px` wide would show if it were not mirrored left to right. Labels are
    /// turned back too, since a detector gives them in the picture's own sense; markers are left out,
    /// since none can be read in a mirrored picture.
    pub fn mirrored_back(&self, width_px: u16) -> Self {
        let last = f64::from(width_px) - 1.0;
        let boards = self.boards.iter().map(|seen| {
            // Backwards along the side with an odd number of squares, so that colours stay.
            let by_column = seen.size.columns % 2 == 0;
            let count = match by_column {
                true => seen.size.columns,
                false => seen.size.rows,
            };
            let corners = seen.view.corners.iter().map(|corner| {
                let [x, y] = corner.position_px;
                let back = |index: u16| (count - 1).saturating_sub(index);
                Corner {
                    i: if by_column { back(corner.i) } else { corner.i },
                    j: if by_column { corner.j } else { back(corner.j) },
                    position_px: [last - x, y],
                    sigma_px: corner.sigma_px,
                }
            });
            SeenBoard {
                size: seen.size,
                view: View {
                    corners: corners.collect(),
                },
            }
        });
        Self {
            boards: boards.collect(),
            markers: Vec::new(),
            mirrored: false,
        }
    }

    /// The target's own markers.
    pub(super) fn markers_of(&self, target: &OverlapTarget) -> Vec<&MarkerView> {
        let own = |marker: &&SeenMarker| {
            marker.dictionary == target.dictionary && marker.view.id == target.id
        };
        let markers = self.markers.iter().filter(own);
        markers.map(|marker| &marker.view).collect()
    }
}

/// The target's chessboard, if it has one.
pub(super) fn board(target: &Target) -> Option<&Board> {
    match target {
        Target::Chessboard(board) => Some(board),
        Target::Overlap(target) => Some(&target.board),
        Target::Marker(_) => None,
    }
}

/// The target, if it is a board with a marker.
pub(super) fn overlap(target: &Target) -> Option<&OverlapTarget> {
    match target {
        Target::Overlap(target) => Some(target),
        Target::Chessboard(_) | Target::Marker(_) => None,
    }
}
