//! The command line as a person or a script meets it.

mod bad_input;
mod board;
mod common;
mod demo;
mod verbs;
mod water;
