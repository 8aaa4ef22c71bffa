//! The cheapest cut through a lattice of pixels.
//!
//! Two exact ways: [`shortest_cycle`] in the dual lattice where one piece of the picture is the
//! left eye's and one the right's, which is the rule, and [`max_flow`] for everything else.

mod corners;
mod labels;
mod lattice;
mod line;
mod max_flow;
mod shortest_cycle;
#[cfg(test)]
mod tests;

pub use lattice::{Cut, Lattice, LatticeError, MAX_COST, Side};
pub use max_flow::max_flow;
pub use shortest_cycle::shortest_cycle;

impl Lattice {
    /// The cheapest cut, by whichever way is exact here.
    pub fn cut(&self) -> Cut {
        shortest_cycle(self).unwrap_or_else(|| max_flow(self))
    }
}
