//! Campaigns: one scenario, one law, many seeds.
//!
//! [`simulation`] runs one trial in lock step: world, sensor or renderer ([`eye`]), pilot, and back. [`entry`] is what is
//! kept of it, a line of a campaign's file. [`compare`] pairs two campaigns by seed.
//!
//! A trial depends on its scenario, its seed and its settings alone. Who runs which trial where, and in which
//! order, is not decided here.

pub mod simulation;

pub mod eye;

pub mod entry;

pub mod statistics;

pub mod compare;

pub use compare::{Comparison, Paired};
pub use entry::{CampaignEntry, CampaignSettings};
pub use eye::DrawnEye;
pub use simulation::{Eye, Simulation, View, Witness};
