//! Drives the real program over the channel.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]

mod clip;
mod media;

mod decoding;
mod files;
mod hostile;
mod other_sources;
mod ports;
mod roles;
mod rtsp;
