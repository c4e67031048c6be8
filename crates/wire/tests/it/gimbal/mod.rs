//! The MAVLink gimbal protocol.

mod bench;
mod exchange;

mod frames;
mod hostile;
mod reader;
mod session;
mod signing;
mod zooming;
