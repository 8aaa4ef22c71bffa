//! ArUco markers of OpenCV's predefined dictionaries.

use calib_targets_aruco::builtins::{BUILTIN_DICTIONARY_NAMES, builtin_dictionary};
use serde::{Deserialize, Serialize};

use super::{MARKER_MM, TargetError, short};

/// Names of the dictionaries, as in OpenCV.
pub fn dictionary_names() -> &'static [&'static str] {
    BUILTIN_DICTIONARY_NAMES
}

/// An ArUco marker to scale (Garrido-Jurado et al. 2014).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Dictionary, as OpenCV names it, such as `DICT_4X4_50`.
    pub dictionary: String,
    /// Id in the dictionary.
    pub id: u32,
    /// Side of the black border, mm.
    pub side_mm: f64,
}

impl Marker {
    /// Refuses a marker that does not exist or has no printable size.
    pub(super) fn check(&self) -> Result<(), TargetError> {
        TargetError::check("side of the marker, mm", self.side_mm, MARKER_MM)?;
        self.code().map(|_| ())
    }

    /// Modules along a side, the black border of one module included.
    ///
    /// # Errors
    /// [`TargetError`] if there is no such marker.
    pub fn modules(&self) -> Result<usize, TargetError> {
        Ok(self.code()?.0 + 2)
    }

    /// Module in column `x` and row `y` from the top left, border included, is black.
    ///
    /// # Errors
    /// [`TargetError`] if there is no such marker.
    pub fn black(&self) -> Result<impl Fn(usize, usize) -> bool, TargetError> {
        let (inner, code) = self.code()?;
        Ok(move |x: usize, y: usize| {
            let border = x == 0 || y == 0 || x > inner || y > inner;
            // The table's first bit is the lowest; a set bit is black.
            border || code >> ((y - 1) * inner + x - 1) & 1 == 1
        })
    }

    /// Side of a module, mm.
    pub(super) fn module_mm(&self) -> Result<f64, TargetError> {
        Ok(self.side_mm / self.modules()? as f64)
    }

    pub(super) fn words(&self) -> String {
        let (dictionary, id) = (&self.dictionary, self.id);
        format!(
            "Marker {dictionary}, id {id}, side {} mm",
            short(self.side_mm)
        )
    }

    /// Inner modules along a side, and their bits.
    fn code(&self) -> Result<(usize, u64), TargetError> {
        let dictionary =
            builtin_dictionary(&self.dictionary).ok_or_else(|| TargetError::NoDictionary {
                name: self.dictionary.clone(),
            })?;
        let codes = dictionary.codes();
        let code = codes.get(self.id as usize).ok_or(TargetError::NoId {
            dictionary: self.dictionary.clone(),
            id: self.id,
            last: codes.len() - 1,
        })?;
        Ok((dictionary.marker_size(), *code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marker(dictionary: &str, id: u32) -> Marker {
        Marker {
            dictionary: dictionary.into(),
            id,
            side_mm: 60.0,
        }
    }

    /// Inner modules row by row, the first the highest bit, white is 1.
    fn white_bits(marker: &Marker) -> u64 {
        let (black, n) = (marker.black().unwrap(), marker.modules().unwrap());
        let inner = |k: usize| 1..=k - 2;
        let modules = inner(n).flat_map(|y| inner(n).map(move |x| (x, y)));
        modules.fold(0, |bits, (x, y)| bits << 1 | u64::from(!black(x, y)))
    }

    /// First, seventh and last marker as OpenCV 5.0's `generateImageMarker` draws them.
    #[test]
    fn markers_equal_opencv() {
        type Drawn = (&'static str, usize, [(u32, u64); 3]);
        let drawn: [Drawn; 10] = [
            ("DICT_4X4_50", 4, [(0, 0xb532), (7, 0xc4f2), (49, 0x5013)]),
            (
                "DICT_5X5_1000",
                5,
                [(0, 0x145b2bc), (7, 0xe2146b), (999, 0x1f7921d)],
            ),
            (
                "DICT_6X6_250",
                6,
                [(0, 0x1e3dd82a6), (7, 0x88a50f29a), (249, 0x703d38a60)],
            ),
            (
                "DICT_7X7_50",
                7,
                [
                    (0, 0x1bab8d94b9415),
                    (7, 0x7942db1117b6),
                    (49, 0xe555f24151c7),
                ],
            ),
            (
                "DICT_ARUCO_ORIGINAL",
                5,
                [(0, 0x1084210), (7, 0x10842ee), (1023, 0xe739ce)],
            ),
            (
                "DICT_APRILTAG_16h5",
                4,
                [(0, 0xd8c4), (7, 0xa2e7), (29, 0x74f5)],
            ),
            (
                "DICT_APRILTAG_25h9",
                5,
                [(0, 0x11fa755), (7, 0x1ab74c1), (34, 0xe7133a)],
            ),
            (
                "DICT_APRILTAG_36h10",
                6,
                [(0, 0xe16549538), (7, 0x7fa7ed722), (2319, 0x96c23da7b)],
            ),
            (
                "DICT_APRILTAG_36h11",
                6,
                [(0, 0x21a146bab), (7, 0x2b874a608), (586, 0xced27dc17)],
            ),
            (
                "DICT_ARUCO_MIP_36h12",
                6,
                [(0, 0xd2b63a09d), (7, 0x5248c541f), (249, 0x4d58dbea0)],
            ),
        ];
        for (name, inner, ids) in drawn {
            for (id, bits) in ids {
                let marker = marker(name, id);
                assert_eq!(marker.modules(), Ok(inner + 2), "{name}");
                assert_eq!(white_bits(&marker), bits, "{name} {id}");
            }
            let last = ids[2].0;
            let error = marker(name, last + 1).check().unwrap_err();
            assert!(error.to_string().contains(&format!("0 to {last}")));
        }
    }

    #[test]
    fn the_border_is_black_all_round() {
        let marker = marker("DICT_4X4_50", 8);
        let black = marker.black().unwrap();
        for k in 0..6 {
            assert!(black(k, 0) && black(k, 5) && black(0, k) && black(5, k));
        }
    }

    #[test]
    fn all_dictionaries_of_opencv_are_there() {
        assert_eq!(dictionary_names().len(), 22);
        let error = marker("DICT_9X9", 0).check().unwrap_err().to_string();
        assert!(error.contains("DICT_9X9") && error.contains("DICT_APRILTAG_36h11"));
    }
}
