//! The evaluation program: measures the tracker, the simulator and the camera laws against their
//! requirements, fits the motion of the simulated target, and renders sample views.
//!
//! ```text
//! cargo run --release -p barrelman-eval --
//! tracker|selection|training-samples|detector|detector-scenes|simulator|calibration|search|guidance|held-marks|law|views|fit|closed-loop|faults|link-latency|zoom
//! ```
//! The exit status is 1 if a requirement is missed or a command fails.
//!
//! The recorded clips and trials may not be redistributed. They are read from a folder beside the repository.

mod tracker;

mod detector;

mod simulator;

mod calibration;
mod guidance;
mod held_marks;
mod law;
mod search;

mod views;

mod closed_loop;
mod faults;
mod link_latency;
mod zoom;

mod output;
mod parallel;
mod rng_of_name;
mod statistics;
mod svg;
mod vehicle;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use output::print_line;

#[derive(Debug, Parser)]
#[command(name = "barrelman-eval", max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure the tracker on real clips and generated scenes: accuracy, confidence, cost.
    Tracker(tracker::Options),
    /// Measure selections that were drawn on an earlier video frame.
    Selection(tracker::past_selection::SelectionOptions),
    /// Write samples for fitting the tracker's refinement network.
    TrainingSamples(tracker::training_samples::TrainingOptions),
    /// Measure an object detector on real clips, rendered scenes and empty water.
    Detector(detector::Options),
    /// Render pictures to train a detector on, with the boxes of all people and boats.
    DetectorScenes(detector::ScenesOptions),
    /// Compare simulated trials with recorded ones.
    Simulator(simulator::Options),
    /// Calibrate drawn cameras in the simulator, and compare with the truth.
    Calibration(calibration::Options),
    /// Let the boat leave the picture in a blind time, and search for it.
    Search(search::Options),
    /// Compare the guidance laws of the boat on the same seeds.
    Guidance(guidance::Options),
    /// Measure the marks that trackers hold on people.
    HeldMarks(held_marks::Options),
    /// Compare the camera laws on the same seeds.
    Law(law::Options),
    /// Render named views of the simulator as PNG files.
    Views(views::Options),
    /// Fit the motion of the simulated laboratory target to the recorded trials.
    Fit(simulator::FitOptions),
    /// Let each vehicle hold the boat in the simulator, through its protocol.
    ClosedLoop(closed_loop::Options),
    /// Let every fault, and every pair of faults, happen in virtual time, and measure the time until the
    /// camera rests.
    Faults(faults::Options),
    /// Measure the time from a command to its bytes on the port, through the guard.
    LinkLatency(link_latency::Options),
    /// Measure the zoom that keeps the boat's size, beside a fixed zoom.
    Zoom(zoom::Options),
}

fn main() -> ExitCode {
    let (name, result) = match Cli::parse().command {
        Command::Tracker(options) => ("tracker", tracker::run(&options)),
        Command::Selection(options) => ("selection", tracker::past_selection::run(&options)),
        Command::TrainingSamples(options) => {
            ("training-samples", tracker::training_samples::run(&options).map(|()| true))
        }
        Command::Detector(options) => ("detector", detector::run(&options).map(|()| true)),
        Command::DetectorScenes(options) => {
            ("detector-scenes", detector::write_scenes(&options).map(|()| true))
        }
        Command::Simulator(options) => ("simulator", simulator::run(&options)),
        Command::Calibration(options) => ("calibration", calibration::run(&options)),
        Command::Search(options) => ("search", search::run(&options)),
        Command::Guidance(options) => ("guidance", guidance::run(&options)),
        Command::HeldMarks(options) => ("held-marks", held_marks::run(&options)),
        Command::Law(options) => ("law", law::run(&options)),
        Command::Views(options) => ("views", views::render(&options).map(|()| true)),
        Command::Fit(options) => ("fit", simulator::fit_target(&options).map(|()| true)),
        Command::ClosedLoop(options) => ("closed-loop", closed_loop::run(&options)),
        Command::Faults(options) => ("faults", faults::run(&options)),
        Command::LinkLatency(options) => ("link-latency", link_latency::run(&options)),
        Command::Zoom(options) => ("zoom", zoom::run(&options)),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            print_line(&format!("{name}: {error:#}"));
            ExitCode::FAILURE
        }
    }
}
