//! From a localisation to a camera command.
//!
//! A [`percept::Percept`] is what a localisation means to a camera law: how far out of the region the target is
//! and in which direction. A law turns percepts into [`barrelman_vocab::CameraCommand`]s:
//! [`schema::MotorSchema`] is the paper's, [`optimal::OptimalLaw`] the one with the least energy,
//! [`law::CameraLaw`] whichever was chosen.
//!
//! What must not be here: pixels other than image coordinates, clocks, randomness, allocation, vehicle signs
//! (they are applied where a command leaves), and any decision on whether the camera may move at all
//! (that is the pilot's).
#![forbid(unsafe_code)]

pub mod region;
mod ring;

pub mod percept;

pub mod law_input;

pub mod schema;

pub mod centring;

pub mod camera_model;

pub mod bearing;

pub mod view;

pub mod transfer;

pub mod optimal;

pub mod shadow;

pub mod law;

pub use bearing::{Bearing, BearingFilter, BearingNoise};
pub use camera_model::CameraModel;
pub use centring::CentringGains;
pub use law::{CameraLaw, Law, LawSettings};
pub use law_input::LawInput;
pub use optimal::{OptimalLaw, OptimalMode, OptimalSettings, Tuning};
pub use percept::Percept;
pub use region::Region;
pub use schema::{MotorSchema, Sector};
pub use shadow::{ShadowController, ShadowStep};
pub use transfer::Transfer;
