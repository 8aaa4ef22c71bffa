//! One module a verb.

mod align;
mod bake;
mod board;
mod calibrate;
mod capture;
mod demo;
mod design;
mod detect;
mod inspect;
mod lookup;
mod matching;
mod register;
mod simulate;
mod stitch;
mod verify;
mod view;
mod water;

use crate::report::Report;

/// What to do.
#[derive(clap::Subcommand)]
pub enum Verb {
    Demo(demo::Args),
    Design(Box<design::Args>),
    Board(board::Args),
    Detect(detect::Args),
    Capture(Box<capture::Args>),
    Calibrate(Box<calibrate::Args>),
    Bake(bake::Args),
    Register(Box<register::Args>),
    Align(Box<align::Args>),
    Verify(verify::Args),
    Stitch(Box<stitch::Args>),
    View(Box<view::Args>),
    Lookup(lookup::Args),
    Inspect(inspect::Args),
    Match(matching::Args),
    Simulate(simulate::Args),
    Water(water::Args),
}

impl Verb {
    /// Does it.
    pub fn run(self) -> anyhow::Result<Report> {
        match self {
            Self::Demo(args) => demo::run(&args),
            Self::Design(args) => design::run(&args),
            Self::Board(args) => board::run(&args),
            Self::Detect(args) => detect::run(&args),
            Self::Capture(args) => capture::run(&args),
            Self::Calibrate(args) => calibrate::run(&args),
            Self::Bake(args) => bake::run(&args),
            Self::Register(args) => register::run(&args),
            Self::Align(args) => align::run(&args),
            Self::Verify(args) => verify::run(&args),
            Self::Stitch(args) => stitch::run(&args),
            Self::View(args) => view::run(&args),
            Self::Lookup(args) => lookup::run(&args),
            Self::Inspect(args) => inspect::run(&args),
            Self::Match(args) => matching::run(&args),
            Self::Simulate(args) => simulate::run(&args),
            Self::Water(args) => water::run(&args),
        }
    }
}
