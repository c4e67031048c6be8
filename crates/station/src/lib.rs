//! The program: command line, configuration, threads, clocks, sockets and files.
//!
//! Everything that touches the world is here and nowhere else; everything that decides something is not. A live
//! run is in [`live`], the video in [`video`], the vehicle's port in [`link`].

pub mod cli;
pub mod commands;

pub mod config;
pub mod tracker;

pub mod campaign;
pub mod scenario;

pub mod live;

pub mod link;
pub mod video;

pub mod emulator;
pub mod world;

pub mod film;
pub mod overlay;

pub mod clock;
pub mod fault;
pub mod input;
pub mod law_choice;
pub mod logging;
pub mod output;
pub mod progress;
pub mod secrets;
