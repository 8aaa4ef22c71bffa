//! `FileStorage` XML: the same names and values as in YAML, one element each.

use std::collections::BTreeMap;

use roxmltree::{Document, Node, ParsingOptions};
use serde_json::{Map, Value};

use super::syntax;
use crate::io::CalibFileError;

/// Most elements and texts of a file that is believed.
const MAX_NODES: u32 = 1 << 16;

/// Names and values below `opencv_storage`.
pub fn values(text: &str) -> Result<BTreeMap<String, Value>, CalibFileError> {
    let options = ParsingOptions {
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    let document =
        Document::parse_with_options(text, options).map_err(|error| syntax(error.to_string()))?;
    let root = document.root_element();
    if root.tag_name().name() != "opencv_storage" {
        let found = root.tag_name().name().to_owned();
        return Err(CalibFileError::value(
            "root element",
            &found,
            "opencv_storage",
        ));
    }
    let mut values = BTreeMap::new();
    for element in elements(&root) {
        let name = element.tag_name().name().to_owned();
        let value = match elements(&element).next() {
            None => scalar(element.text().unwrap_or_default()),
            Some(_) => map(&element),
        };
        if values.insert(name.clone(), value).is_some() {
            return Err(syntax(format!("duplicate element {name}")));
        }
    }
    Ok(values)
}

fn elements<'a>(node: &Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(Node::is_element)
}

/// One level of names: `rows`, `cols`, `dt` and `data` of a matrix.
fn map(element: &Node<'_, '_>) -> Value {
    let mut map = Map::new();
    for child in element.children().filter(Node::is_element) {
        let (name, text) = (child.tag_name().name(), child.text().unwrap_or_default());
        let value = match name {
            "data" => text.split_whitespace().map(scalar).collect(),
            _ => scalar(text),
        };
        map.insert(name.to_owned(), value);
    }
    Value::Object(map)
}

/// A number, or else a text, without its quotes.
fn scalar(text: &str) -> Value {
    let text = text.trim();
    if let Ok(whole) = text.parse::<i64>() {
        return whole.into();
    }
    match text.parse::<f64>() {
        // One that is not finite becomes null.
        Ok(number) => number.into(),
        Err(_) => text.trim_matches('"').into(),
    }
}

#[cfg(test)]
mod tests {
    use crate::io::any::Format;
    use crate::io::opencv::FileStorage;

    const XML: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n\
        <calibration_time>\"Mon 10:20\"</calibration_time>\n\
        <image_width>960</image_width>\n<image_height>720</image_height>\n\
        <!-- a comment -->\n\
        <Camera_Matrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  \
        <dt>d</dt>\n  <data>\n    3.0e+02 0. 4.795e+02 0. 300.\n    359.5 0. 0. 1.</data></Camera_Matrix>\n\
        <D type_id=\"opencv-matrix\"><rows>4</rows><cols>1</cols><dt>d</dt>\
        <data>-0.01 2.0e-03 -1e-3 2e-4</data></D>\n\
        <image_points type_id=\"opencv-matrix\"><rows>1</rows><cols>2</cols><dt>\"2f\"</dt>\
        <data>1. .Nan 3. 4.</data></image_points>\n</opencv_storage>\n";

    fn good() -> String {
        XML.replace("Camera_Matrix", "camera_matrix")
    }

    #[test]
    fn xml_and_yaml_hold_the_same_camera() {
        let storage = FileStorage::parse(&good()).unwrap();
        let calib = storage.fisheye().unwrap();
        assert_eq!(calib.size_px, Some([960, 720]));
        assert_eq!(calib.model.centre_px, [479.5, 359.5]);
        assert_eq!(calib.model.distortion, [-0.01, 0.002, -0.001, 0.0002]);
        assert_eq!(storage.words["calibration_time"], "Mon 10:20");
        let yaml = FileStorage::parse(&FileStorage::from(&calib).to_text()).unwrap();
        assert_eq!(yaml.fisheye().unwrap(), calib);
        let with_mark = format!("\u{feff}{}", good());
        assert_eq!(FileStorage::parse(&with_mark).unwrap(), storage);
        assert_eq!(Format::of(&with_mark), Some(Format::OpenCvXml));
    }

    #[test]
    fn hostile_xml_is_refused_with_words() {
        for (text, part) in [
            (good().replace("3.0e+02", ".Nan"), "camera_matrix.data"),
            (good().replace("3.0e+02", "nan"), "finite"),
            (good().replace("<rows>3<", "<rows>4000000000<"), "rows"),
            (
                good().replace("opencv_storage", "storage"),
                "opencv_storage",
            ),
            (good().replace("</D>", ""), "OpenCV"),
            (good().replace("image_points", "D"), "duplicate"),
            ("<opencv_storage>".repeat(200_000), "OpenCV"),
            (
                format!("<!DOCTYPE a [<!ENTITY b \"c\">]>{}", &good()[21..]),
                "DTD",
            ),
            ("<".to_owned(), "OpenCV"),
        ] {
            let refused = FileStorage::parse(&text).unwrap_err().to_string();
            assert!(refused.contains(part), "{part}: {refused}");
        }
    }
}
