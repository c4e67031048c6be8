//! Measures the simulator against the recorded trials of the laboratory, and fits the simulated target's
//! motion to them.
//!
//! Each table is a file of this folder. `validation` is judged: the confidence intervals of simulated and
//! recorded metrics must overlap for most metrics. The other tables explain it, or measure the simulator and
//! the laws alone; nothing in them is required.
//!
//! The recorded trials may not be redistributed. They are read from a folder beside the repository.

mod validation;

mod localisation_noise;
mod out_of_picture;
mod speed_by_distance;
mod tracker_spikes;

mod boat_speed;
mod centring;
mod motor_schema_rate;
mod real_time_factor;

mod fit;

mod excursion_summary;
mod laboratory;
mod motion;
mod options;
mod position_jump;

pub(crate) use options::{FitOptions, Options};

use anyhow::Result;

use options::TableName;

/// Prints the chosen tables. Returns whether every requirement that was judged holds.
///
/// # Errors
/// If recorded trials or scenarios cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let folder = options.trials_folder()?;
    if options.includes(TableName::LocalisationNoise) {
        localisation_noise::run(&folder, options)?;
    }
    if options.includes(TableName::SpeedByDistance) {
        speed_by_distance::run(&folder, options)?;
    }
    if options.includes(TableName::OutOfPicture) {
        out_of_picture::run(&folder, options)?;
    }
    if options.includes(TableName::TrackerSpikes) {
        tracker_spikes::run(&folder, options)?;
    }
    if options.includes(TableName::MotorSchemaRate) {
        motor_schema_rate::run(options)?;
    }
    if options.includes(TableName::Centring) {
        centring::run(options)?;
    }
    if options.includes(TableName::BoatSpeed) {
        boat_speed::run(options)?;
    }
    if options.includes(TableName::RealTimeFactor) {
        real_time_factor::run(options)?;
    }
    if options.includes(TableName::Validation) { validation::run(&folder, options) } else { Ok(true) }
}

/// Fits the target's motion and prints the values for the scenario's file.
///
/// # Errors
/// If recorded trials or scenarios cannot be used.
pub(crate) fn fit_target(options: &FitOptions) -> Result<()> {
    let folder = options.trials_folder()?;
    fit::run(&folder, options)
}
