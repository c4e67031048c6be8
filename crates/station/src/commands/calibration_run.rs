//! The test motions of `barrelman calibrate axes`: a live run without an operator.

use std::io::{Write as _, stdout};

use anyhow::{Context, Result, bail};
use barrelman_experiments::calibration::{CalibrationRecorder, CalibrationResult, CannotTell, SpeedSweep};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_sim::scenario::CameraSetup;
use barrelman_vocab::speed_curve::AxisSpeeds;
use barrelman_vocab::{TestMotions, VehicleProfile, Videos};

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
use crate::simulated_source::LiveWorld;
use crate::source_url::SourceUrl;

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
    if let SourceUrl::Simulated(url) = &source
        && !latency_is_known
    {
        take_over(&LiveWorld::load(&url.world)?.scenario().camera, &mut configuration.profile);
    }
    let given = Given { source, link, clock };
    if !configuration.profile.protocol.speeds_are_rates() && configuration.profile.speeds.is_none() {
        let speeds = measure_speeds(&configuration, &given)?;
        configuration.profile = configuration.profile.with_speeds(speeds);
    }
    let made = make_motions(&configuration, &given, TestMotions::Axes, record)?;
    Ok(CalibrationRun {
        configuration,
        result: made.map(|made| made.with_recorder(CalibrationRecorder::result)),
    })
}

/// What the runs of a calibration have in common, beside the configuration.
struct Given {
    source: SourceUrl,
    link: LinkUrl,
    clock: Clock,
}

/// Measures how fast the camera turns at its speeds, one run for each.
fn measure_speeds(configuration: &Configuration, given: &Given) -> Result<AxisSpeeds> {
    let mut sweep = SpeedSweep::default();
    while let Some(([pan, tilt], provisional)) = sweep.next() {
        let profile = configuration.profile.clone().with_speeds(provisional);
        let configuration = Configuration { profile, ..configuration.clone() };
        let made = make_motions(&configuration, given, TestMotions::Speed, None)?;
        let Some(measured) = made.map(|made| made.with_recorder(CalibrationRecorder::speeds)) else {
            bail!("the test motions were not all made: the speeds were not measured");
        };
        let line = format!(
            "speed {pan:.2} of pan: {}; speed {tilt:.2} of tilt: {}",
            rate_text(&measured.pan),
            rate_text(&measured.tilt)
        );
        writeln!(stdout(), "{line}")?;
        sweep.take(measured).context("the speeds cannot be told")?;
    }
    sweep.curves().context("the speeds cannot be told")
}

fn rate_text(rate: &Result<f64, CannotTell>) -> String {
    match rate {
        Ok(rate) => format!("{:.1} deg/s", rate.to_degrees()),
        Err(CannotTell::NotFollowing { .. }) => "not seen to turn".to_owned(),
        Err(CannotTell::Unsteady { gain_error, .. }) => {
            format!("the repetitions differ by {:.0} %", 100.0 * gain_error)
        }
        Err(CannotTell::NotMeasured | CannotTell::Bars(_)) => "not measured".to_owned(),
    }
}

/// Makes test motions in a run of its own; `None`: they were not all made.
fn make_motions(
    configuration: &Configuration,
    given: &Given,
    motions: TestMotions,
    record: Option<OutputFile>,
) -> Result<Option<LiveCalibration>> {
    let link = Some(given.link.clone());
    let source = Source::load(given.source.clone(), secrets::trust(&configuration.video_trust)?)?;
    ensure_camera_has_world(link.as_ref(), &source)?;
    let http = vehicle_over_http(configuration, link.as_ref())?;
    let guard = needed_guard(configuration, link.as_ref())?;
    let calibration = LiveCalibration::new(motions, configuration.profile.camera.focal_share);
    let session = Session {
        pilot: build_pilot(configuration, command_path(link.as_ref()))?,
        configuration,
        sources: Videos::one(source),
        link,
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
        clock: given.clock,
    };
    match session.run()? {
        RunEnd::Failed(why) => bail!("{why}"),
        RunEnd::Requested(_) | RunEnd::VideoEnded => Ok(calibration.is_complete().then_some(calibration)),
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
