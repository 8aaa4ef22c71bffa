//! Bits and Huffman codes of a JPEG scan.

use super::sound::JpegDamage;

/// Bits of coded data, most significant first. A stuffed zero after 0xff is left out; a marker ends
/// the bits.
pub(super) struct Bits<'a> {
    data: &'a [u8],
    /// Next byte to be taken in.
    at: usize,
    /// The next bits, from the top down.
    held: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    /// Bits from byte `at` on.
    pub fn new(data: &'a [u8], at: usize) -> Self {
        Self {
            data,
            at,
            held: 0,
            count: 0,
        }
    }

    fn refill(&mut self) {
        while self.count <= 56 {
            let Some(&byte) = self.data.get(self.at) else {
                return;
            };
            if byte == 0xff {
                if self.data.get(self.at + 1) != Some(&0) {
                    return;
                }
                self.at += 1;
            }
            self.at += 1;
            self.held |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    /// Takes `count` bits, at most 16.
    pub fn take(&mut self, count: u32) -> Result<u32, JpegDamage> {
        if count == 0 {
            return Ok(0);
        }
        if self.count < count {
            self.refill();
            if self.count < count {
                return Err(JpegDamage::EndsEarly);
            }
        }
        let value = (self.held >> (64 - count)) as u32;
        self.held <<= count;
        self.count -= count;
        Ok(value)
    }

    /// Takes one code and gives its symbol.
    pub fn symbol(&mut self, table: &Huffman) -> Result<u8, JpegDamage> {
        if self.count < 16 {
            self.refill();
        }
        let next = (self.held >> 48) as u16;
        let (length, symbol) = table.find(next).ok_or(if self.count < 16 {
            JpegDamage::EndsEarly
        } else {
            JpegDamage::Scan
        })?;
        self.take(length)?;
        Ok(symbol)
    }

    /// Where the next whole byte of coded data, or the marker, is: bits of a begun byte are passed
    /// over.
    pub fn position(&self) -> usize {
        let mut at = self.at;
        // Bytes that were taken in but not begun.
        for _ in 0..self.count / 8 {
            at -= 1;
            let is_stuffed = at > 0 && self.data[at] == 0 && self.data[at - 1] == 0xff;
            at -= usize::from(is_stuffed);
        }
        at
    }
}

/// Codes of a Huffman table (T.81, annex C).
#[derive(Clone)]
pub(super) struct Huffman {
    /// By the first eight bits: length and symbol; length 0 for longer codes.
    short: [(u8, u8); 256],
    /// For each length, the first 16-bit value above its codes, and the symbol index that a code
    /// of this length has less its value.
    long: [(u32, i32); 17],
    symbols: Vec<u8>,
}

impl Huffman {
    /// From the number of codes of each length, 1 to 16 bits, and their symbols in order; `None` if
    /// there are more codes than lengths allow or fewer symbols than codes.
    pub fn new(counts: &[u8; 16], symbols: &[u8]) -> Option<Self> {
        let mut table = Self {
            short: [(0, 0); 256],
            long: [(0, 0); 17],
            symbols: symbols.to_vec(),
        };
        let (mut code, mut index) = (0_u32, 0_usize);
        for (length, &count) in (1_u32..).zip(counts) {
            table.long[length as usize].1 = index as i32 - code as i32;
            for _ in 0..count {
                let symbol = *symbols.get(index)?;
                if code >> length != 0 {
                    return None;
                }
                if length <= 8 {
                    let first = (code << (8 - length)) as usize;
                    table.short[first..first + (1 << (8 - length))].fill((length as u8, symbol));
                }
                code += 1;
                index += 1;
            }
            table.long[length as usize].0 = code << (16 - length);
            code <<= 1;
        }
        Some(table)
    }

    /// Length and symbol of the code that `next` begins with.
    fn find(&self, next: u16) -> Option<(u32, u8)> {
        let (length, symbol) = self.short[usize::from(next >> 8)];
        if length > 0 {
            return Some((length.into(), symbol));
        }
        let next = u32::from(next);
        let length = (9..=16_u32).find(|length| next < self.long[*length as usize].0)?;
        let index = (next >> (16 - length)) as i32 + self.long[length as usize].1;
        Some((length, *self.symbols.get(usize::try_from(index).ok()?)?))
    }
}
