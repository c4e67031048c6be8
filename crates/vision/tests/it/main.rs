//! What the tracker promises.

mod agreement_with_opencv;
mod allocation;
mod any_input;
mod following;
mod scenes;
mod selecting;
