//! Tests of the trackers through their public interface.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking, its helpers too")]

mod agreement_with_opencv;
mod allocation;
mod any_input;
mod any_input_to_the_fused_tracker;
mod following;
mod following_by_pattern_and_colour;
mod gaps;
mod scenes;
mod selecting;
mod selecting_for_the_fused_tracker;
