//! Finds pictures in a stream of bytes, and the next one after damage or padding.

use std::io::{self, Read};
use std::ops::Range;

use super::marker;

/// Longest picture that is read, bytes: a broken stream must not fill the memory.
const MAX_PICTURE_BYTES: usize = 64 << 20;
/// Bytes asked for at once.
const READ_BYTES: usize = 1 << 16;
/// A picture without its beginning is at least so long, bytes; less is a stray marker.
const MIN_HEADLESS_BYTES: usize = 16;

/// What comes next in a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Found<'a> {
    /// Bytes from a start of image to the end of image, or to where the next picture starts. Its
    /// structure is whole; its scans may not be.
    Picture(&'a [u8]),
    /// A picture that was cut off or lost its beginning; what is left of it.
    Damaged(&'a [u8]),
    /// Nothing more.
    End,
}

/// Reads pictures one after the other.
///
/// Whatever stands between the end of one picture and the start of the next is passed over:
/// padding, headers of a transport, noise. A picture that breaks off costs itself alone: the search
/// goes on inside it.
pub(crate) struct Scanner<R> {
    reader: R,
    data: Vec<u8>,
    /// Of `data`, what was handed out or passed over.
    used: usize,
    is_at_end: bool,
    /// Pictures seen so far, whole or not.
    any: bool,
    /// What is passed over belongs to a picture that was counted already.
    in_damage: bool,
}

/// How a picture's bytes end.
enum Outcome {
    Whole(Range<usize>),
    /// Its bytes, and where to search on.
    Cut(Range<usize>, usize),
}

impl<R: Read> Scanner<R> {
    /// A scanner over any reader.
    pub fn new(reader: R) -> Self {
        Self {
            reader,
            data: Vec::new(),
            used: 0,
            is_at_end: false,
            any: false,
            in_damage: false,
        }
    }

    /// The next picture.
    ///
    /// # Errors
    /// The reader's own.
    pub fn next(&mut self) -> io::Result<Found<'_>> {
        self.data.drain(..self.used);
        self.used = 0;
        let Some(start) = self.seek()? else {
            let lost = std::mem::take(&mut self.used);
            let is_lost = self.is_headless(lost);
            self.used = self.data.len();
            return Ok(if is_lost {
                Found::Damaged(&self.data[..lost])
            } else {
                Found::End
            });
        };
        if self.is_headless(start) {
            self.in_damage = true;
            self.used = start;
            return Ok(Found::Damaged(&self.data[..start]));
        }
        self.any = true;
        match self.picture(start)? {
            Outcome::Whole(range) => {
                self.in_damage = false;
                self.used = range.end;
                Ok(Found::Picture(&self.data[range]))
            }
            Outcome::Cut(range, on) => {
                self.in_damage = true;
                self.used = on;
                Ok(Found::Damaged(&self.data[range]))
            }
        }
    }

    /// Whether the bytes before `end` are a picture that lost its beginning: after other pictures,
    /// something that ends as one.
    fn is_headless(&self, end: usize) -> bool {
        let before = &self.data[..end];
        let padding = before.iter().rev().take_while(|byte| **byte == 0).count();
        let before = &before[..end - padding];
        self.any
            && !self.in_damage
            && before.len() >= MIN_HEADLESS_BYTES
            && before.ends_with(&[0xff, marker::EOI])
    }

    /// Where the next start of image is. `None` at the end, with all bytes in `used`.
    fn seek(&mut self) -> io::Result<Option<usize>> {
        let mut from = 0;
        loop {
            let found = starts(&self.data[from..]).map(|at| from + at);
            if found.is_some() {
                return Ok(found);
            }
            from = self.data.len().saturating_sub(2);
            if from > MAX_PICTURE_BYTES {
                self.data.drain(..from);
                from = 0;
            }
            if !self.fill()? {
                self.used = self.data.len();
                return Ok(None);
            }
        }
    }

    /// Reads more; `false` at the end.
    fn fill(&mut self) -> io::Result<bool> {
        if self.is_at_end {
            return Ok(false);
        }
        let before = self.data.len();
        self.data.resize(before + READ_BYTES, 0);
        let read = loop {
            match self.reader.read(&mut self.data[before..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        self.data.truncate(before + *read.as_ref().unwrap_or(&0));
        self.is_at_end = matches!(read, Ok(0));
        Ok(read? > 0)
    }

    /// Whether byte `at` is there, read if need be.
    fn has(&mut self, at: usize) -> io::Result<bool> {
        while self.data.len() <= at {
            if !self.fill()? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Follows the segments (ITU-T T.81, B.1.1) of the picture at `start`, so that the end of a
    /// thumbnail inside one is not taken for the picture's.
    fn picture(&mut self, mut start: usize) -> io::Result<Outcome> {
        let mut at = start + 2;
        let mut has_scan = false;
        loop {
            if at - start > MAX_PICTURE_BYTES {
                return Ok(Outcome::Cut(start..at, at));
            }
            // Zeros, and any number of 0xff, may stand before a marker.
            while self.has(at + 1)? && (self.data[at] == 0 || self.data[at..at + 2] == [0xff; 2]) {
                at += 1;
            }
            if !self.has(at + 1)? {
                let end = self.data.len();
                return Ok(if has_scan {
                    Outcome::Whole(start..end)
                } else {
                    Outcome::Cut(start..end, end)
                });
            }
            let [first, kind] = [self.data[at], self.data[at + 1]];
            if first != 0xff || kind == 0 {
                return Ok(Outcome::Cut(start..at, start + 2));
            }
            match kind {
                marker::EOI => return Ok(Outcome::Whole(start..at + 2)),
                marker::SOI if at == start + 2 => {
                    // Doubled.
                    start = at;
                    at += 2;
                }
                marker::SOI if has_scan => return Ok(Outcome::Whole(start..at)),
                marker::SOI => return Ok(Outcome::Cut(start..at, at)),
                marker::TEM | marker::RST0..=marker::RST7 => at += 2,
                _ => {
                    let Some(end) = self.segment(at, kind)? else {
                        return Ok(Outcome::Cut(start..at, start + 2));
                    };
                    // A cut segment reaches into the next picture, whose start may be taken for its
                    // length; the bytes behind tell whether it starts with the last ones.
                    let with_next = (end..end + 2)
                        .find(|at| !matches!(self.has(*at), Ok(true)))
                        .unwrap_or(end + 2);
                    let from_length = &self.data[at + 2..with_next];
                    let may_hold = may_hold_picture(kind, &from_length[2..]);
                    if let (Some(inside), false) = (starts(from_length), may_hold) {
                        let next = at + 2 + inside;
                        return Ok(Outcome::Cut(start..next, next));
                    }
                    at = end;
                    if kind == marker::SOS {
                        has_scan = true;
                        let Some(end) = self.coded_data(start, at)? else {
                            let end = self.data.len();
                            return Ok(Outcome::Whole(start..end));
                        };
                        at = end;
                    }
                }
            }
        }
    }

    /// Where the segment whose marker is at `at` ends; `None` if it is cut or its length cannot be.
    fn segment(&mut self, at: usize, kind: u8) -> io::Result<Option<usize>> {
        if kind < marker::SOF0 || !self.has(at + 3)? {
            return Ok(None);
        }
        let length = usize::from(u16::from_be_bytes([self.data[at + 2], self.data[at + 3]]));
        if length < 2 || !self.has(at + 1 + length)? {
            return Ok(None);
        }
        Ok(Some(at + 2 + length))
    }

    /// Where the coded data from `at` on end: at a marker that is no restart. `None` where the
    /// stream ends.
    fn coded_data(&mut self, start: usize, mut at: usize) -> io::Result<Option<usize>> {
        while at - start <= MAX_PICTURE_BYTES && self.has(at + 1)? {
            let marks = self.data[at..].windows(2).position(|pair| {
                pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | marker::RST0..=marker::RST7)
            });
            match marks {
                Some(offset) => return Ok(Some(at + offset)),
                // The last byte may be the first half of a marker.
                None => at = self.data.len() - 1,
            }
        }
        Ok((at - start > MAX_PICTURE_BYTES).then_some(at))
    }
}

/// Where a picture may start: a start of image and the first half of another marker.
fn starts(data: &[u8]) -> Option<usize> {
    data.windows(3)
        .position(|three| three == [0xff, marker::SOI, 0xff])
}

/// Segments of applications may hold a thumbnail, which is a picture itself.
fn may_hold_picture(kind: u8, body: &[u8]) -> bool {
    match kind {
        marker::APP0 => body.starts_with(b"JFXX\0"),
        _ => (marker::APP0..=marker::APP15).contains(&kind),
    }
}

#[cfg(test)]
mod tests;
