//! The pilot's guarantees: when the camera may move, and when it must not.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod allocation;
mod any_input;
mod boats_answer;
mod boundary;
mod by_hand;
mod candidates;
mod detections;
mod frames;
mod held_marks;
mod licences;
mod modes;
mod motion;
mod opposed_motion;
mod scenes;
mod searching;
mod telemetry;
mod unasked_motion;
mod vehicle;
mod verification;
mod vessel;
mod zooming;
