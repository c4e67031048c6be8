//! Both ends of the protocols: of the Fotokite Pro against transcripts that were written by hand
//! (`fixtures/fotokite-pro/README.md` describes their format), of the Fotokite Sigma, of ONVIF cameras and of
//! MAVLink gimbals against each other in virtual time. The tracking camera against what ground stations send.

// Tests read fixture files, and fail by panicking.
#![allow(clippy::disallowed_methods, clippy::panic, clippy::unwrap_used)]

mod transcript;

mod client;
mod commands;
mod gimbal;
mod hostile;
mod station;
mod telemetry;

mod sigma_conversation;
mod talk;

mod sigma_calls;
mod sigma_control;
mod sigma_hostile;
mod sigma_motion;

mod onvif_conversation;
mod onvif_session;

mod tracking_camera;
