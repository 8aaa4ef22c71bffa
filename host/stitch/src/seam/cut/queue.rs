//! A queue for shortest paths with small whole costs (Dial 1969): a bucket for every distance, used
//! in turn. Equal distances leave in a fixed order.

/// Nodes by distance; all distances in it at a time lie within a range.
#[derive(Debug)]
pub(super) struct Buckets {
    buckets: Vec<Vec<u32>>,
    at: u32,
    held: usize,
}

impl Buckets {
    /// For distances that lie at most `range` beyond the smallest one held.
    pub(super) fn new(range: usize) -> Self {
        let buckets = vec![Vec::new(); (range + 1).next_power_of_two()];
        Self {
            buckets,
            at: 0,
            held: 0,
        }
    }

    /// Empty, with distances from `from` on.
    pub(super) fn restart(&mut self, from: u32) {
        self.buckets.iter_mut().for_each(Vec::clear);
        (self.at, self.held) = (from, 0);
    }

    pub(super) fn push(&mut self, distance: u32, node: u32) {
        let slot = distance as usize & (self.buckets.len() - 1);
        self.buckets[slot].push(node);
        self.held += 1;
    }

    /// A node of the smallest distance, with it.
    pub(super) fn pop(&mut self) -> Option<(u32, u32)> {
        if self.held == 0 {
            return None;
        }
        loop {
            let slot = self.at as usize & (self.buckets.len() - 1);
            if let Some(node) = self.buckets[slot].pop() {
                self.held -= 1;
                return Some((self.at, node));
            }
            self.at += 1;
        }
    }
}
