//! The campaign of the boats: the vessel's part of the pilot, its gate, its link and its guard.
//!
//! The camera is engaged, too, and follows the boat as the pilot commands; the faults are those of the video,
//! of the processes, of the console, and of the line to the boat.

pub(super) mod run;

pub(super) mod oracle;
mod program;
mod script;

mod console;
mod person_picture;
mod truth_tracker;

pub(super) mod vessel_kind;

mod lab_receiver;
mod rover;

mod boat;
