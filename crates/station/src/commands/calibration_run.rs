//! The test motions of `barrelman calibrate axes`: a live run without an operator.

use anyhow::{Context, Result, bail};
use barrelman_experiments::calibration::{CalibrationRecorder, CalibrationResult};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_sim::scenario::CameraSetup;
use barrelman_vocab::{VehicleProfile, Videos};

use super::run::guards::needed_guard;
use super::run::sources::ensure_camera_has_world;
use super::run::{build_pilot, override_key};
use crate::cli::{CalibrateAxesArgs, UsageError};
use crate::config::Configuration;
use crate::link::{LinkUrl, command_path, vehicle_over_http};
use crate::live::calibration::LiveCalibration;
use crate::live::faults::FaultInjector;
use crate::live::run_loop::RunEnd;
use crate::live::session::{Outputs, Session};
use crate::live::source::Source;
use crate::secrets;

/// A calibration that was run: the configuration that was in force, and what was measured (`None`: nothing).
pub struct CalibrationRun {
    /// The configuration.
    pub configuration: Configuration,
    /// What was measured.
    pub result: Option<CalibrationResult>,
}

/// Runs the test motions of a calibration.
///
/// # Errors
/// If the configuration, the video or the link cannot be used, or the run failed.
pub fn calibrate(
    args: &CalibrateAxesArgs,
    record: Option<OutputFile>,
    clock: Clock,
) -> Result<CalibrationRun> {
    let mut file = args.connection.config_file()?;
    override_key(&mut file.link.url, &args.connection.link);
    override_key(&mut file.vehicle.profile, &args.profile);
    let latency_is_known = file.vehicle.video_latency_s.is_some();
    let mut configuration = Configuration::resolve(&file).context("the configuration is not usable")?;
    let Some(video) = &configuration.video else {
        return Err(UsageError(
            "no video source: give --video, or video.url in the configuration".to_owned(),
        )
        .into());
    };
    if configuration.second_video.is_some() {
        return Err(UsageError("a calibration turns one camera: omit the second video".to_owned()).into());
    }
    let Some(link) = configuration.link.as_deref().map(LinkUrl::parse).transpose()? else {
        return Err(UsageError("no link: give --link, or link.url in the configuration".to_owned()).into());
    };
    let source = secrets::source_url(video, &configuration.video_login)?;
    let source = Source::load(source, secrets::trust(&configuration.video_trust)?)?;
    ensure_camera_has_world(Some(&link), &source)?;
    if let Some(world) = source.world().filter(|_| !latency_is_known) {
        take_over(&world.scenario().camera, &mut configuration.profile);
    }
    let http = vehicle_over_http(&configuration, Some(&link))?;
    let guard = needed_guard(&configuration, Some(&link))?;
    let calibration = LiveCalibration::new(configuration.profile.camera.focal_share);
    let session = Session {
        pilot: build_pilot(&configuration, command_path(Some(&link)))?,
        configuration: &configuration,
        sources: Videos::one(source),
        link: Some(link),
        guard,
        vessel_guard: None,
        http,
        outputs: Outputs { record, ..Outputs::default() },
        selection: None,
        waits_for_selection: true,
        console: None,
        tracking_camera: None,
        tak: None,
        share: None,
        detector: None,
        engage: false,
        calibration: Some(calibration.clone()),
        fault_injector: FaultInjector::default(),
        clock,
    };
    match session.run()? {
        RunEnd::Failed(why) => bail!("{why}"),
        RunEnd::Requested(_) | RunEnd::VideoEnded => {
            let result = calibration.with_recorder(CalibrationRecorder::result);
            Ok(CalibrationRun { configuration, result })
        }
    }
}

/// Takes the latency and the focal length of a simulated camera over to the profile.
fn take_over(camera: &CameraSetup, profile: &mut VehicleProfile) {
    profile.video_latency = camera.latency();
    // A calibrated lens has its own focal length.
    if profile.camera.lens.is_none() {
        profile.camera.focal_share = camera.optics.focal_px / f64::from(camera.frame.width);
    }
}
