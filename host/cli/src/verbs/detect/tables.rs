//! Corners and markers as data.

use std::fmt::Write;

use serde_json::{Value, json};
use tectum_calibrate::session::Detections;

use crate::report::path_json;

/// One entry a picture that could be read.
pub fn pictures(detections: &Detections) -> Vec<Value> {
    let pictures = detections.readable().into_iter().map(|(index, detected)| {
        let corners = detected.found.board.iter().flat_map(|view| &view.corners);
        let corners: Vec<Value> = corners
            .map(|corner| {
                let [x, y] = corner.position_px;
                json!({ "i": corner.i, "j": corner.j, "x": x, "y": y, "sigma_px": corner.sigma_px })
            })
            .collect();
        let markers = detected.found.markers.iter();
        let markers: Vec<Value> = markers
            .map(|marker| json!({ "id": marker.id, "corners": marker.corners_px }))
            .collect();
        json!({
            "file": path_json(&detections.pictures[index].file),
            "sha256": detected.sha256,
            "size_px": detected.size_px,
            "corners": corners,
            "other_board": detected.found.other_board.map(|board| board.to_string()),
            "markers": markers,
        })
    });
    pictures.collect()
}

/// One line a corner: of boards with i and j, of markers with id and the corner's number.
pub fn csv(detections: &Detections) -> String {
    let mut text = String::from("file,kind,id,i,j,x_px,y_px,sigma_px\n");
    for (index, detected) in detections.readable() {
        let file = quoted(&detections.pictures[index].file.display().to_string());
        for corner in detected.found.board.iter().flat_map(|view| &view.corners) {
            let ([x, y], sigma) = (corner.position_px, corner.sigma_px);
            let _ = writeln!(
                text,
                "{file},board,,{},{},{x},{y},{sigma}",
                corner.i, corner.j
            );
        }
        for marker in &detected.found.markers {
            for (number, [x, y]) in marker.corners_px.iter().enumerate() {
                let _ = writeln!(text, "{file},marker,{},{number},,{x},{y},", marker.id);
            }
        }
    }
    text
}

/// A field of a CSV file (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn names_with_commas_and_quotes_are_quoted() {
        assert_eq!(quoted("a b.png"), "a b.png");
        assert_eq!(quoted("a,\"b\".png"), "\"a,\"\"b\"\".png\"");
    }
}
