//! The program: command line, configuration, threads, links and live runs.
//!
//! A live run is in [`live`], its requests in [`operator`], its published state in [`snapshot`], the web page for both in
//! [`console`], the vehicle's port in [`link`], the demo in [`demo`], the emulated ground station in [`emulator`]. Trackers, laws and safety are other crates; this crate connects them to the machine.

pub mod cli;
pub mod commands;

pub mod config;

mod encrypted_video;
pub mod secrets;
pub mod source_url;

pub mod live;

pub mod operator;
pub mod snapshot;

pub mod console;

pub mod link;

pub mod tracking_camera;

pub mod simulated_source;

pub mod demo;
pub mod emulator;

mod interruption;
pub mod logging;
pub mod progress;

#[cfg(test)]
mod test_scenes;
