//! Tests of the laws and their models, by tables and by properties.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod bearing;
mod camera_model;
mod earth;
mod intermittent;
mod lab_guidance;
mod line_of_sight;
mod motor_schema;
mod optimal;
mod size_keeping;
mod transfer;
mod water;
