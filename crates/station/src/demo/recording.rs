//! The recording of a drive, with the drive's effective configuration as its first message.

use anyhow::Result;
use barrelman_experiments::campaign::recording::{RecordedRun, TrialRecorder};
use barrelman_experiments::drive::DriveSetup;
use barrelman_host::output::OutputFile;

use crate::config::Configuration;
use crate::config::vessel::VesselConfig;

/// Begins the recording of a drive in `file`, if there is one.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn begin(file: Option<OutputFile>, setup: &DriveSetup) -> Result<Option<TrialRecorder>> {
    let begin = |file| {
        let simulated = Configuration::simulated(setup.profile.clone(), setup.law, setup.tracker)?;
        let configuration =
            Configuration { vessel: setup.commands_vessel().then(VesselConfig::simulated), ..simulated };
        let run = RecordedRun { video: setup.url.to_string(), trial: None };
        TrialRecorder::without_film(file, configuration.to_toml()?, run, &configuration.profile)
    };
    file.map(begin).transpose()
}
