//! The program: command line, configuration, threads, links and live runs.
//!
//! A live run is in [`live`], the vehicle's port in [`link`], the demo in [`demo`]. Requests, published
//! state, the web page, emulated vehicles, trackers, laws and safety are other crates; this crate connects
//! them to the machine.

pub mod cli;
pub mod commands;

pub mod config;

mod encrypted_video;
pub mod secrets;
pub mod source_url;

pub mod live;

pub mod link;

pub mod detector;
pub mod share;
pub mod tak;
pub mod tracking_camera;

pub mod simulated_source;

pub mod demo;

mod interruption;
pub mod logging;
pub mod progress;
