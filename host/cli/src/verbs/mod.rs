//! One module a verb.

mod bake;
mod demo;
mod inspect;
mod lookup;
mod simulate;
mod stitch;
mod verify;

use crate::report::Report;

/// What to do.
#[derive(clap::Subcommand)]
pub enum Verb {
    Demo(demo::Args),
    Bake(bake::Args),
    Verify(verify::Args),
    Stitch(stitch::Args),
    Lookup(lookup::Args),
    Inspect(inspect::Args),
    Simulate(simulate::Args),
}

impl Verb {
    /// Does it.
    pub fn run(self) -> anyhow::Result<Report> {
        match self {
            Self::Demo(args) => demo::run(&args),
            Self::Bake(args) => bake::run(&args),
            Self::Verify(args) => verify::run(&args),
            Self::Stitch(args) => stitch::run(&args),
            Self::Lookup(args) => lookup::run(&args),
            Self::Inspect(args) => inspect::run(&args),
            Self::Simulate(args) => simulate::run(&args),
        }
    }
}
