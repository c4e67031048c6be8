//! Guidance laws: from where the boat is and where it shall go to a [`VesselCommand`].
//!
//! [`lab::LabLaw`] is the law of the paper's laboratory, in image coordinates. [`line_of_sight::LineOfSight`]
//! steers over the water plane; [`track::BoatTrack`] estimates position, course and speed for it,
//! [`route::Route`] is the line that it follows, and [`clearance`] keeps it away from people and forbidden
//! areas.
//!
//! What must not be here: clocks, randomness, allocation per step, the vehicle's own signs, and any decision
//! whether the boat may move at all.
//!
//! Courses and headings are 0 ahead (along the water frame's y) and positive to the right. A positive rudder
//! turns the boat to the right.
//!
//! [`VesselCommand`]: barrelman_vocab::VesselCommand

mod answer;
pub mod input;

pub mod lab;

pub mod clearance;
mod estimate;
pub mod route;
pub mod track;
pub mod tuning;

pub mod line_of_sight;

pub use barrelman_vocab::VesselLimits;
pub use input::{BoatFix, Destination, GuidanceInput, GuidanceState, GuidanceStep, KeepOut};
pub use lab::{LabBranch, LabInput, LabLaw, LabSettings};
pub use line_of_sight::LineOfSight;
pub use tuning::{LineOfSightTuning, VesselModel};
