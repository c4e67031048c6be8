//! Tests of the shared types.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod boxes;
mod frames_of_reference;
mod pictures;
mod profiles;
mod random_numbers;
mod rates;
mod times;
