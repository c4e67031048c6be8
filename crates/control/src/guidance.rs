//! Guidance laws: from where the boat is and where it shall go to a [`VesselCommand`].
//!
//! [`lab::LabLaw`] is the law of the paper's laboratory, in pixel coordinates.
//!
//! What must not be here: clocks, randomness, allocation per step, the vehicle's own signs, and any decision whether the
//! boat may move at all.
//!
//! Courses and headings are 0 ahead (along the water frame's y) and positive to the right. A positive rudder turns
//! the boat to the right.
//!
//! [`VesselCommand`]: barrelman_vocab::VesselCommand

pub mod lab;

pub use lab::{LabBranch, LabInput, LabLaw, LabSettings};
