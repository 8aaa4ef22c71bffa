//! One named command for each chore and CI step.
fn main() {}
