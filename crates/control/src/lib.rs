//! Camera laws: from a localisation to a camera command.
//!
//! A [`percept::Percept`] describes how far and in which direction the target is out of the region. A law
//! computes [`barrelman_vocab::CameraCommand`]s from percepts: [`motor_schema::MotorSchema`] is the paper's
//! law, [`optimal::OptimalLaw`] needs the least energy, and [`law::CameraLaw`] holds the chosen law.
//!
//! What must not be here: pixel data, clocks, randomness, allocation per step, vehicle signs (they are
//! applied at the vehicle boundary), and any decision whether the camera may move at all (`barrelman-pilot`
//! decides it).
#![forbid(unsafe_code)]

pub mod region;
mod ring;

pub mod percept;

pub mod law_input;

pub mod motor_schema;

pub mod centring;

pub mod camera_model;

pub mod bearing;

pub mod view;

pub mod transfer;

pub mod water;

pub mod guidance;

pub mod optimal;

pub mod shadow;

pub mod law;
pub mod size_keeping;

pub use bearing::{Bearing, BearingFilter, BearingNoise};
pub use camera_model::CameraModel;
pub use centring::CentringGains;
pub use law::{CameraLaw, Law, LawSettings};
pub use law_input::LawInput;
pub use motor_schema::{MotorSchema, Sector};
pub use optimal::{IntermittentTuning, OptimalLaw, OptimalSettings, Tuning};
pub use percept::Percept;
pub use region::Region;
pub use shadow::{ShadowController, ShadowStep};
pub use transfer::{Transfer, TransferSolution};
