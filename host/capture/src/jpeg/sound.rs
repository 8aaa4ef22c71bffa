//! Whether a JPEG picture is whole: every block of its scans is there and can be read.
//!
//! Decoders show what is missing as plain grey, so a picture is walked code by code before it is
//! used. No pixel is computed for that.

use super::bits::{Bits, Huffman};
use super::{decode, marker, tables};

/// Coded data after the last block that encoders may leave, bytes: to fill up a word of their own.
const MAX_LEFT_OVER_BYTES: usize = 8;
/// Greatest mean of a block of 8-bit samples, times 8 as a DCT gives it, with as much again for
/// encoders that are careless: anything beyond is a code that was read in the wrong place.
const MAX_DC: i32 = 2048;

/// What is wrong with a JPEG picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum JpegDamage {
    /// It does not begin as one.
    #[error("it does not begin as a JPEG picture")]
    Start,
    /// A header is cut, contradicts another, or is missing.
    #[error("its headers are damaged")]
    Header,
    /// The picture data end before the last pixel.
    #[error("its picture data end early")]
    EndsEarly,
    /// The picture data hold something that cannot be.
    #[error("its picture data are damaged")]
    Scan,
}

/// What a sound JPEG picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JpegInfo {
    /// Width and height, px.
    pub size_px: [u16; 2],
    /// Whether it relies on the standard Huffman tables, which motion JPEG may leave out.
    pub lacks_tables: bool,
}

/// One component of a frame.
#[derive(Debug, Clone, Copy)]
struct Component {
    id: u8,
    sampling: [usize; 2],
    quantisation: usize,
    is_scanned: bool,
}

/// What the headers said so far.
struct Headers {
    size_px: [u16; 2],
    components: Vec<Component>,
    huffman: [[Option<Huffman>; 4]; 2],
    /// Quantisation of the mean of a block, by table.
    dc_step: [Option<i32>; 4],
    restart_every: usize,
    info: JpegInfo,
    /// Progressive, arithmetic, or more than 8 bits.
    is_unusual: bool,
}

/// Checks that `jpeg` is one whole picture. Baseline pictures are walked to the last block; others
/// are decoded. Bytes after its end, or a missing end marker, do no harm.
///
/// # Errors
/// [`JpegDamage`] for a picture that must not be shown.
pub fn check_jpeg(jpeg: &[u8]) -> Result<JpegInfo, JpegDamage> {
    if !jpeg.starts_with(&[0xff, marker::SOI]) {
        return Err(JpegDamage::Start);
    }
    let mut headers = Headers {
        size_px: [0, 0],
        components: Vec::new(),
        huffman: Default::default(),
        dc_step: [None; 4],
        restart_every: 0,
        info: JpegInfo {
            size_px: [0, 0],
            lacks_tables: false,
        },
        is_unusual: false,
    };
    let mut at = 2;
    while let Some((kind, after)) = next_marker(jpeg, at)? {
        at = after;
        match kind {
            marker::EOI => break,
            marker::SOI | marker::TEM | marker::RST0..=marker::RST7 => continue,
            _ => {}
        }
        let length = jpeg.get(at..at + 2).ok_or(JpegDamage::Header)?;
        let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
        let body = jpeg.get(at + 2..at + length.max(2));
        let body = body.ok_or(JpegDamage::Header)?;
        at += length.max(2);
        headers.read(kind, body).ok_or(JpegDamage::Header)?;
        if kind == marker::SOS {
            if headers.is_unusual {
                return headers.decoded(jpeg);
            }
            at = headers.scan(body, jpeg, at)?;
        }
    }
    if headers.components.is_empty() {
        return Err(JpegDamage::Header);
    }
    if headers
        .components
        .iter()
        .any(|component| !component.is_scanned)
    {
        return Err(JpegDamage::EndsEarly);
    }
    Ok(headers.info)
}

/// The marker at `at` and where it ends; `None` at the end of the data. Bytes of a fill before a
/// marker (0xff, and zeros, which some encoders put between segments) are passed over.
fn next_marker(jpeg: &[u8], mut at: usize) -> Result<Option<(u8, usize)>, JpegDamage> {
    loop {
        match jpeg.get(at..) {
            None | Some([] | [_]) => return Ok(None),
            Some([0xff, 0xff, ..]) | Some([0, ..]) => at += 1,
            Some([0xff, kind, ..]) if *kind != 0 => return Ok(Some((*kind, at + 2))),
            Some(_) => return Err(JpegDamage::Header),
        }
    }
}

impl Headers {
    /// Takes in a segment.
    fn read(&mut self, kind: u8, body: &[u8]) -> Option<()> {
        match kind {
            marker::DHT => self.read_huffman(body),
            marker::DQT => self.read_quantisation(body),
            marker::DRI => {
                self.restart_every = u16::from_be_bytes(*body.first_chunk()?).into();
                Some(())
            }
            marker::JPG => None,
            marker::DAC => {
                self.is_unusual = true;
                Some(())
            }
            marker::SOF0..=marker::SOF15 => self.read_frame(kind, body),
            _ => Some(()),
        }
    }

    fn read_huffman(&mut self, mut body: &[u8]) -> Option<()> {
        while let Some((id, rest)) = body.split_first() {
            let (counts, rest) = rest.split_first_chunk::<16>()?;
            let total = counts.iter().map(|count| usize::from(*count)).sum();
            let (symbols, rest) = rest.split_at_checked(total)?;
            let of_class = self.huffman.get_mut(usize::from(id >> 4))?;
            let table = of_class.get_mut(usize::from(id & 15))?;
            *table = Some(Huffman::new(counts, symbols)?);
            body = rest;
        }
        Some(())
    }

    fn read_quantisation(&mut self, mut body: &[u8]) -> Option<()> {
        while let Some((id, rest)) = body.split_first() {
            let (first, length) = match id >> 4 {
                0 => (i32::from(*rest.first()?), 64),
                1 => (i32::from(u16::from_be_bytes(*rest.first_chunk()?)), 128),
                _ => return None,
            };
            *self.dc_step.get_mut(usize::from(id & 15))? = Some(first);
            body = rest.get(length..)?;
        }
        Some(())
    }

    fn read_frame(&mut self, kind: u8, body: &[u8]) -> Option<()> {
        let (&[bits, h1, h0, w1, w0, count], rest) = body.split_first_chunk::<6>()?;
        self.size_px = [u16::from_be_bytes([w1, w0]), u16::from_be_bytes([h1, h0])];
        self.info.size_px = self.size_px;
        self.is_unusual |= !matches!(kind, marker::SOF0 | marker::SOF1) || bits != 8;
        let parts = rest.as_chunks::<3>().0.get(..usize::from(count))?;
        // A second frame header in one picture is the header of the next one.
        if !self.components.is_empty() || parts.is_empty() || self.size_px.contains(&0) {
            return None;
        }
        for &[id, sampling, quantisation] in parts {
            let sampling = [sampling >> 4, sampling & 15].map(usize::from);
            if !sampling.iter().all(|side| (1..=4).contains(side)) || quantisation > 3 {
                return None;
            }
            self.components.push(Component {
                id,
                sampling,
                quantisation: quantisation.into(),
                is_scanned: false,
            });
        }
        Some(())
    }

    /// A picture of an unusual kind: sound if it can be decoded.
    fn decoded(&self, jpeg: &[u8]) -> Result<JpegInfo, JpegDamage> {
        if decode::is_decodable(jpeg, self.size_px) {
            Ok(self.info)
        } else {
            Err(JpegDamage::Scan)
        }
    }

    /// Walks the scan whose data begin at `start`; where its data end.
    fn scan(&mut self, header: &[u8], jpeg: &[u8], start: usize) -> Result<usize, JpegDamage> {
        let parts = self.scanned(header).ok_or(JpegDamage::Header)?;
        let most = |side: usize| {
            let sides = self.components.iter().map(|c| c.sampling[side]);
            sides.max().unwrap_or(1)
        };
        let most = [most(0), most(1)];
        let size_px = self.size_px.map(usize::from);
        // Blocks of each component in a unit, and units in the picture (T.81, A.2).
        let (units, blocks): (usize, Vec<usize>) = if let [one] = &parts[..] {
            let sampling = self.components[one.component].sampling;
            let side = |i: usize| (size_px[i] * sampling[i]).div_ceil(most[i]).div_ceil(8);
            (side(0) * side(1), vec![1])
        } else {
            let side = |i: usize| size_px[i].div_ceil(8 * most[i]);
            let blocks = parts.iter().map(|part| {
                let [h, v] = self.components[part.component].sampling;
                h * v
            });
            (side(0) * side(1), blocks.collect())
        };
        let mut bits = Bits::new(jpeg, start);
        let mut means = vec![0; parts.len()];
        let mut restarts = 0;
        for unit in 0..units {
            if self.restart_every > 0 && unit > 0 && unit % self.restart_every == 0 {
                let at = restart(jpeg, bits.position(), restarts)?;
                bits = Bits::new(jpeg, at);
                means.fill(0);
                restarts = (restarts + 1) % 8;
            }
            for ((part, mean), blocks) in parts.iter().zip(&mut means).zip(&blocks) {
                for _ in 0..*blocks {
                    block(&mut bits, part, mean)?;
                }
            }
        }
        for part in &parts {
            self.components[part.component].is_scanned = true;
        }
        end_of_scan(jpeg, bits.position())
    }

    /// Which components a scan holds, with their tables.
    fn scanned(&mut self, header: &[u8]) -> Option<Vec<Part>> {
        let (&count, rest) = header.split_first()?;
        let parts = rest.as_chunks::<2>().0.get(..usize::from(count))?;
        if parts.is_empty() || self.components.is_empty() {
            return None;
        }
        parts
            .iter()
            .map(|&[id, numbers]| {
                let component = self.components.iter().position(|c| c.id == id)?;
                let quantisation = self.components[component].quantisation;
                let numbers = [numbers >> 4, numbers & 15].map(usize::from);
                Some(Part {
                    component,
                    dc: self.table(0, numbers[0])?,
                    ac: self.table(1, numbers[1])?,
                    dc_step: self.dc_step[quantisation]?,
                })
            })
            .collect()
    }

    /// The picture's own table, or the standard one.
    fn table(&mut self, class: usize, number: usize) -> Option<Huffman> {
        if let Some(table) = self.huffman[class].get(number)? {
            return Some(table.clone());
        }
        self.info.lacks_tables = true;
        tables::standard(class, number)
    }
}

/// A component in a scan.
struct Part {
    component: usize,
    dc: Huffman,
    ac: Huffman,
    dc_step: i32,
}

/// Walks one block of 64 coefficients.
fn block(bits: &mut Bits<'_>, part: &Part, mean: &mut i32) -> Result<(), JpegDamage> {
    let size = u32::from(bits.symbol(&part.dc)?);
    if size > 11 {
        return Err(JpegDamage::Scan);
    }
    let value = bits.take(size)? as i32;
    // T.81, F.2.2.1: values with a leading zero are negative.
    let is_negative = size > 0 && value >> (size - 1) == 0;
    *mean += if is_negative {
        value + 1 - (1 << size)
    } else {
        value
    };
    if (*mean * part.dc_step).abs() > MAX_DC {
        return Err(JpegDamage::Scan);
    }
    let mut next = 1;
    while next < 64 {
        let symbol = bits.symbol(&part.ac)?;
        let (zeros, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
        match (zeros, size) {
            (15, 0) => next += 16,
            (_, 0) => return Ok(()),
            _ => {
                next += zeros + 1;
                bits.take(size)?;
            }
        }
        if next > 64 {
            return Err(JpegDamage::Scan);
        }
    }
    Ok(())
}

/// Past the restart marker of number `number` at `at`.
fn restart(jpeg: &[u8], at: usize, number: u8) -> Result<usize, JpegDamage> {
    let (kind, after) = match next_marker(jpeg, at) {
        Ok(Some(found)) => found,
        Ok(None) => return Err(JpegDamage::EndsEarly),
        Err(_) => return Err(JpegDamage::Scan),
    };
    match kind {
        _ if kind == marker::RST0 + number => Ok(after),
        marker::RST0..=marker::RST7 => Err(JpegDamage::Scan),
        _ => Err(JpegDamage::EndsEarly),
    }
}

/// Where the coded data end that begin at `at`, after the last block: what is left must be a fill.
fn end_of_scan(jpeg: &[u8], at: usize) -> Result<usize, JpegDamage> {
    let rest = &jpeg[at.min(jpeg.len())..];
    let is_marker = |pair: &[u8]| {
        let follows = pair[1] != 0 && pair[1] != 0xff;
        pair[0] == 0xff && follows && !(marker::RST0..=marker::RST7).contains(&pair[1])
    };
    let end = rest.windows(2).position(is_marker).unwrap_or(rest.len());
    let left_over = &rest[..end];
    let is_fill = left_over.iter().all(|byte| matches!(byte, 0 | 0xff));
    if is_fill || left_over.len() <= MAX_LEFT_OVER_BYTES {
        Ok(at + end)
    } else {
        Err(JpegDamage::Scan)
    }
}

#[cfg(test)]
mod tests;
