//! The command line as a person or a script meets it.

mod align;
mod bad_input;
mod board;
mod boards;
mod calibrate;
mod chromium;
mod common;
mod demo;
mod design;
mod detect;
mod ffmpeg;
mod live;
mod matching;
mod motion;
mod page;
mod pipes;
mod readme;
mod register;
mod slips;
mod verbs;
mod water;
