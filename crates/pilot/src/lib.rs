//! The pilot joins localisation and control: each [`Pilot::step`] processes one [`Input`] and returns one
//! [`Outcome`].
//!
//! Live, simulated and replayed runs call the same function; they differ in the source of the inputs and the
//! use of the outcomes. The function is total: it cannot fail or block, and it depends only on its arguments
//! and the pilot's state. It does not allocate after the first few video frames.
//!
//! What must not be here: clocks, threads, files, vehicle signs, protocols, and a second place that decides
//! whether the camera may move: only [`safety`] decides it, and for the boat only [`vessel::gate`].
#![forbid(unsafe_code)]

pub mod step;

pub mod safety;

pub mod licence;
pub mod purpose;
pub mod vehicle;

pub mod calibration;
mod candidates;
pub mod detections;
mod growth;
mod held_marks;
mod history;
pub mod net_yaw;
mod object_trackers;
pub mod on_earth;
mod opposed_motion;
mod proposing;
pub mod search;
mod selecting;
mod sway_estimate;
pub mod unasked_motion;
mod verification;
mod zooming;

pub mod vessel;

pub mod input;
pub mod outcome;
mod refusal;

pub use barrelman_control::LawSettings;
pub use candidates::{Candidate, MAX_CANDIDATES};
pub use detections::{ClassName, Classification, Detection, Detections, MAX_DETECTIONS};
pub use input::Input;
pub use outcome::{Advice, Mode, Notice, Outcome, Refusal};
pub use proposing::ProposedObject;
pub use purpose::Purpose;
pub use safety::NUDGE_RATE_RAD_PER_S;
pub use step::{Pilot, PilotSettings};
pub use vehicle::CommandPath;
pub use vessel::{VesselMode, VesselOutcome, VesselSettings};
