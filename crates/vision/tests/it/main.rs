//! What the tracker promises.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod agreement_with_opencv;
mod allocation;
mod any_input;
mod following;
mod scenes;
mod selecting;
