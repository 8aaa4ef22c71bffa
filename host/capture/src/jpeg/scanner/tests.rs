use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use proptest::prelude::*;

use super::*;
use crate::jpeg::{check_jpeg, with_comment};

/// A reader that gives at most so many bytes at once.
struct Split<'a>(&'a [u8], usize);

impl Read for Split<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.1.min(out.len()).min(self.0.len());
        out[..count].copy_from_slice(&self.0[..count]);
        self.0 = &self.0[count..];
        Ok(count)
    }
}

/// Sound pictures and the number of damaged ones.
fn read(bytes: &[u8], at_once: usize) -> (Vec<Vec<u8>>, usize) {
    let mut scanner = Scanner::new(Split(bytes, at_once));
    let (mut sound, mut damaged) = (Vec::new(), 0);
    loop {
        match scanner.next().unwrap() {
            Found::Picture(jpeg) if check_jpeg(jpeg).is_ok() => sound.push(jpeg.to_vec()),
            Found::Picture(_) | Found::Damaged(_) => damaged += 1,
            Found::End => return (sound, damaged),
        }
    }
}

fn picture(seed: usize) -> Vec<u8> {
    let rgb: Vec<u8> = (0..16 * 16 * 3)
        .map(|i| (i * (7 + seed) % 251) as u8)
        .collect();
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, 60)
        .encode(&rgb, 16, 16, ExtendedColorType::Rgb8)
        .unwrap();
    jpeg
}

#[test]
fn what_stands_between_pictures_is_passed_over() {
    let [a, b] = [picture(0), picture(1)];
    for between in [
        &b""[..],
        &[0; 3],
        &[0xff; 5],
        b"\r\n--boundary\r\nContent-Type: image/jpeg\r\n\r\n",
        &[0xff, 0xd9],
        &[0xff, 0xd8],
    ] {
        let stream = [between, &a, between, &b, between, &a, between].concat();
        let (sound, damaged) = read(&stream, 7);
        let last_start_is_alone = between == [0xff, 0xd8];
        assert_eq!((sound.len(), damaged), (3, 0), "{between:x?}");
        assert!(last_start_is_alone || sound == [a.clone(), b.clone(), a.clone()]);
    }
}

#[test]
fn a_picture_cut_anywhere_costs_itself_alone() {
    let (whole, next) = (picture(2), picture(3));
    let lost_end_only = whole.len() - 3;
    for cut in 3..whole.len() {
        let stream = [&next, &whole[..cut], &next, &next].concat();
        let (sound, damaged) = read(&stream, 64);
        if cut > lost_end_only {
            assert_eq!((sound.len(), damaged), (4, 0), "cut at {cut}");
        } else {
            assert_eq!((sound.len(), damaged), (3, 1), "cut at {cut}");
        }
    }
}

#[test]
fn a_picture_without_its_beginning_is_counted() {
    let (whole, next) = (picture(2), picture(3));
    let stream = [&next, &whole[200..], &next].concat();
    let (sound, damaged) = read(&stream, 64);
    assert_eq!((sound.len(), damaged), (2, 1));
    // But not where a stream begins in the middle of one.
    let (sound, damaged) = read(&[&whole[200..], &next].concat(), 64);
    assert_eq!((sound.len(), damaged), (1, 0));
}

#[test]
fn thumbnails_are_part_of_their_picture() {
    let (whole, small) = (picture(4), picture(5));
    let body = [b"Exif\0\0", &small[..]].concat();
    let length = (body.len() as u16 + 2).to_be_bytes();
    let with_thumbnail = [&[0xff, 0xd8, 0xff, 0xe1][..], &length, &body, &whole[2..]].concat();
    let stream = [&with_thumbnail[..], &whole].concat();
    let (sound, damaged) = read(&stream, 100);
    assert!(sound == [with_thumbnail, whole]);
    assert_eq!(damaged, 0);
}

#[derive(Debug, Clone)]
enum Piece {
    Sound(usize),
    Padding(u8, usize),
    Cut(usize, usize),
    WithoutEnd(usize),
}

fn piece() -> impl Strategy<Value = Piece> {
    prop_oneof![
        3 => (0_usize..4).prop_map(Piece::Sound),
        1 => (prop_oneof![Just(0_u8), Just(0xff), Just(b' ')], 0_usize..40)
            .prop_map(|(byte, count)| Piece::Padding(byte, count)),
        1 => (0_usize..4, 3_usize..600).prop_map(|(seed, cut)| Piece::Cut(seed, cut)),
        1 => (0_usize..4).prop_map(Piece::WithoutEnd),
    ]
}

proptest! {
    #[test]
    fn streams_are_read_as_they_were_put_together(
        pieces in proptest::collection::vec(piece(), 0..12),
        at_once in 1_usize..3000,
    ) {
        let (mut stream, mut wanted, mut cut_off) = (Vec::new(), Vec::new(), 0);
        for (i, piece) in pieces.iter().enumerate() {
            // Each picture is told by its number.
            let numbered = |seed| with_comment(&picture(seed), &i.to_string()).unwrap();
            match *piece {
                Piece::Sound(seed) => {
                    stream.extend(numbered(seed));
                    wanted.push(i);
                }
                // Only zeros and ones can be told from the data of a picture without its end.
                Piece::Padding(byte, count) => {
                    let is_open = matches!(i.checked_sub(1).map(|i| &pieces[i]),
                        Some(Piece::WithoutEnd(_) | Piece::Padding(..)));
                    stream.extend(vec![if is_open { 0 } else { byte }; count]);
                }
                Piece::Cut(seed, cut) => {
                    let whole = numbered(seed);
                    stream.extend(&whole[..cut.min(whole.len() - 10)]);
                    cut_off += 1;
                }
                Piece::WithoutEnd(seed) => {
                    let whole = numbered(seed);
                    stream.extend(&whole[..whole.len() - 2]);
                    wanted.push(i);
                }
            }
        }
        let (sound, damaged) = read(&stream, at_once);
        let numbers: Vec<usize> = sound
            .iter()
            .map(|jpeg| {
                let text = crate::jpeg::first_comment(jpeg).unwrap();
                std::str::from_utf8(text).unwrap().parse().unwrap()
            })
            .collect();
        prop_assert_eq!(numbers, wanted);
        prop_assert_eq!(damaged, cut_off);
    }

    #[test]
    fn any_bytes_come_to_an_end_and_splits_make_no_difference(
        bytes in proptest::collection::vec(
            prop_oneof![any::<u8>(), Just(0xff), Just(0xd8), Just(0xd9), Just(0xda)], 0..300),
        at_once in 1_usize..50,
    ) {
        let all = |at_once| {
            let mut scanner = Scanner::new(Split(&bytes, at_once));
            let mut found = Vec::new();
            loop {
                match scanner.next().unwrap() {
                    Found::End => break,
                    Found::Picture(jpeg) => found.push((true, jpeg.to_vec())),
                    Found::Damaged(part) => found.push((false, part.to_vec())),
                }
                assert!(found.len() <= bytes.len());
            }
            found
        };
        prop_assert_eq!(all(at_once), all(usize::MAX));
    }
}
