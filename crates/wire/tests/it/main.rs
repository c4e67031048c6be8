//! Both ends of the Fotokite Pro's protocol against transcripts that no program wrote
//! (`fixtures/fotokite-pro/README.md` says how they are read).

// Fixtures are files, and a test that cannot go on panics.
#![allow(clippy::disallowed_methods, clippy::panic, clippy::unwrap_used)]

mod transcript;

mod client;
mod commands;
mod hostile;
mod station;
mod telemetry;
