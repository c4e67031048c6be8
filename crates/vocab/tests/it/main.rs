//! What the nouns promise.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod boxes;
mod frames_of_reference;
mod pictures;
mod profiles;
mod rates;
mod times;
