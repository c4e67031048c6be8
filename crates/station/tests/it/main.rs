//! Integration tests: the program run as a process, and the parts of it that need files, devices or threads.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says why it was skipped"
)]

mod program;

mod build_profiles;
mod campaigns;
mod command_line;
mod command_paths;
mod configuration;
mod exported_films;
mod exports;
mod lens;
mod live_scenes;
mod new_drive;
mod output_files;
mod recorder;
mod recording_folder;
mod replays;
mod reports;
mod rooms;
mod run_loop;
mod second_video;
mod secrets;
mod sent_rates;
mod simulated_source;
mod stated_program;
mod status;
