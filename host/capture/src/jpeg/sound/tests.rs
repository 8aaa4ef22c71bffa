use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use proptest::prelude::*;

use super::*;

const SIZE_PX: [u16; 2] = [36, 20];

fn picture(seed: usize) -> Vec<u8> {
    let [width, height] = SIZE_PX.map(u32::from);
    let rgb: Vec<u8> = (0..(width * height * 3) as usize)
        .map(|i| (i * (31 + seed) % 253) as u8)
        .collect();
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, 70)
        .encode(&rgb, width, height, ExtendedColorType::Rgb8)
        .unwrap();
    jpeg
}

/// Where the coded data of `picture` begin.
fn scan_start(jpeg: &[u8]) -> usize {
    let sos = jpeg
        .windows(2)
        .position(|p| p == [0xff, marker::SOS])
        .unwrap();
    sos + 2 + usize::from(u16::from_be_bytes([jpeg[sos + 2], jpeg[sos + 3]]))
}

#[test]
fn a_whole_picture_is_sound_with_or_without_its_end() {
    let jpeg = picture(0);
    let info = check_jpeg(&jpeg).unwrap();
    assert_eq!(info.size_px, SIZE_PX);
    assert!(!info.lacks_tables);
    assert_eq!(check_jpeg(&jpeg[..jpeg.len() - 2]), Ok(info));
    let padded = [&jpeg[..], &[0; 7], &[0xff; 3]].concat();
    assert_eq!(check_jpeg(&padded), Ok(info));
}

#[test]
fn a_scan_cut_anywhere_is_damage_with_or_without_an_end_marker() {
    let jpeg = picture(1);
    // The last byte holds a few bits of the last block at most.
    for cut in scan_start(&jpeg)..jpeg.len() - 3 {
        assert!(check_jpeg(&jpeg[..cut]).is_err(), "cut at {cut}");
        let ended = [&jpeg[..cut], &[0xff, marker::EOI]].concat();
        assert!(check_jpeg(&ended).is_err(), "cut and ended at {cut}");
    }
}

#[test]
fn a_piece_lost_inside_the_scan_is_damage() {
    let jpeg = picture(2);
    let start = scan_start(&jpeg);
    let middle = start + (jpeg.len() - start) / 3;
    let half = (jpeg.len() - start) / 2;
    let lost = [&jpeg[..middle], &jpeg[middle + half..]].concat();
    assert!(check_jpeg(&lost).is_err());
}

#[test]
fn tables_may_be_left_out() {
    let jpeg = picture(3);
    let mut bare = Vec::new();
    let mut at = 2;
    bare.extend(&jpeg[..2]);
    while jpeg[at + 1] != marker::SOS {
        let length = usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
        if jpeg[at + 1] != marker::DHT {
            bare.extend(&jpeg[at..at + 2 + length]);
        }
        at += 2 + length;
    }
    bare.extend(&jpeg[at..]);
    let info = check_jpeg(&bare).unwrap();
    assert!(info.lacks_tables);
    assert_eq!(
        decode::to_rgb8(&bare, SIZE_PX, true).unwrap(),
        decode::to_rgb8(&jpeg, SIZE_PX, true).unwrap()
    );
}

proptest! {
    #[test]
    fn any_bytes_are_told_apart_without_a_panic(
        mut bytes in proptest::collection::vec(any::<u8>(), 0..400),
        cut in 0_usize..2000,
        at in 0_usize..2000,
    ) {
        let _ = check_jpeg(&bytes);
        // Behind a true beginning.
        let jpeg = picture(5);
        let mut mixed = jpeg[..cut.min(jpeg.len())].to_vec();
        mixed.append(&mut bytes);
        let _ = check_jpeg(&mixed);
        let mut flipped = jpeg;
        let at = at % flipped.len();
        flipped[at] ^= 1 << (cut % 8);
        if let Ok(info) = check_jpeg(&flipped) {
            let _ = decode::to_rgb8(&flipped, info.size_px, true);
        }
    }
}
