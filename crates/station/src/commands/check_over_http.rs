//! `barrelman check` of a vehicle that is asked over HTTP: it reads states, and asks for neither control nor
//! motion.

use barrelman_link::url::HttpAddress;
use barrelman_link_http::fotokite_sigma::Sigma;
use barrelman_link_http::onvif::Camera;
use barrelman_link_http::{HttpProtocol, VehicleVideo};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::profile::AxisDynamics;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};
use barrelman_vocab::{AngularRate, Named as _};
use barrelman_wire::fotokite_sigma::json::CameraInfo;
use barrelman_wire::onvif::{Joined, MovingProfile, OnvifSettings};

use super::check_result::{CheckResult, Verdict};
use crate::config::Configuration;
use crate::link::ensure_spoken_at;
use crate::link::named_video::{PermittedHosts, named_video};
use crate::secrets;

/// Checks the vehicle at an address.
pub(super) fn check_over_http(
    address: &HttpAddress,
    configuration: Option<&Configuration>,
    results: &mut Vec<CheckResult>,
) {
    let subject = format!("link {address}");
    let Some(configuration) = configuration else { return };
    let Configuration { link_access, profile, video_stream, .. } = configuration;
    let settings = ensure_spoken_at(address, profile)
        .and_then(|()| secrets::http_settings(address, link_access, profile, video_stream.as_deref()));
    let settings = match settings {
        Ok(settings) => settings,
        Err(error) => {
            results.push(CheckResult::new(subject, Verdict::Failed, format!("{error:#}")));
            return;
        }
    };
    let hosts = PermittedHosts { link: &address.host, configured: configuration.link_video_host.as_deref() };
    match &settings.protocol {
        HttpProtocol::FotokiteSigma(sigma) => match Sigma::reach(&settings, &sigma.credential) {
            Ok(vehicle) => check_sigma(&vehicle, subject, configuration, hosts, results),
            Err(error) => results.push(CheckResult::new(subject, Verdict::Failed, error.to_string())),
        },
        HttpProtocol::Onvif(onvif) => match Camera::reach(&settings, onvif) {
            Ok(camera) => check_onvif(camera, subject, onvif, hosts, results),
            Err(error) => results.push(CheckResult::new(subject, Verdict::Failed, error.to_string())),
        },
    }
}

fn check_sigma(
    vehicle: &Sigma,
    subject: String,
    configuration: &Configuration,
    hosts: PermittedHosts<'_>,
    results: &mut Vec<CheckResult>,
) {
    results.push(CheckResult::new(subject, Verdict::Ok, "the vehicle answers"));
    let info = match vehicle.camera_info() {
        Ok(info) => info,
        Err(said) => {
            let subject = if said == Acceptance::TokenRefused { "token" } else { "camera" };
            results.push(CheckResult::new(subject, Verdict::Failed, said.text()));
            return;
        }
    };
    results.push(CheckResult::new("token", Verdict::Ok, "the vehicle accepts the token"));
    results.push(check_speeds(&info, configuration));
    results.push(match vehicle.is_camera_online() {
        Ok(true) => CheckResult::new("camera", Verdict::Ok, "it is on line"),
        Ok(false) => CheckResult::new("camera", Verdict::Failed, Acceptance::NoCamera.text()),
        Err(said) => CheckResult::new("camera", Verdict::Failed, said.text()),
    });
    results.push(match vehicle.controller() {
        Ok(Some(name)) => {
            let details = format!(
                "{name} controls the vehicle: `run` waits in the queue until the control is given up"
            );
            CheckResult::new("control", Verdict::Warning, details)
        }
        Ok(None) => CheckResult::new("control", Verdict::Ok, "nobody controls the vehicle"),
        Err(said) => CheckResult::new("control", Verdict::Failed, said.text()),
    });
    let told = vehicle.video(configuration.video_stream.as_deref());
    results.push(check_video(told.map_err(|error| error.to_string()), hosts));
}

fn check_onvif(
    camera: Camera,
    subject: String,
    settings: &OnvifSettings,
    hosts: PermittedHosts<'_>,
    results: &mut Vec<CheckResult>,
) {
    let joined = camera.joined();
    let details = format!(
        "the camera answers, and its profile {} moves; a motion ends by itself after {} s",
        joined.profile,
        joined.timeout.as_secs_f64()
    );
    results.push(CheckResult::new(subject, Verdict::Ok, details));
    results.extend(joined.moving.iter().map(|profile| profile_result(profile, joined)));
    let zooms = if joined.full.zoom.is_some() { "the camera zooms" } else { "the camera does not zoom" };
    results.push(CheckResult::new("zoom", Verdict::Ok, zooms));
    results.push(match &settings.speeds {
        Some(AxisSpeeds { pan, tilt }) => {
            let degrees = |curve: &SpeedCurve| {
                let degrees = |rate: AngularRate| rate.radians_per_second().to_degrees();
                format!("{:.1} to {:.0} deg/s", degrees(curve.least()), degrees(curve.largest()))
            };
            let details = format!("pan {}, tilt {}", degrees(pan), degrees(tilt));
            CheckResult::new("speeds", Verdict::Ok, details)
        }
        None => CheckResult::new("speeds", Verdict::Warning, Acceptance::NotCalibrated.text()),
    });
    results.push(check_video(camera.video().map(Some).map_err(|error| error.to_string()), hosts));
}

/// A media profile that moves, and how it is chosen.
fn profile_result(profile: &MovingProfile, joined: &Joined) -> CheckResult {
    let MovingProfile { token, name, .. } = profile;
    let called = name.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
    let used = if *token == joined.profile { "used" } else { "not used" };
    let details =
        format!("{}{called}: {used}; video.stream = {token:?} chooses it", profile.equipment().name);
    CheckResult::new("profile", Verdict::Ok, details)
}

/// Compares the speeds that the vehicle takes with those of the profile.
fn check_speeds(info: &CameraInfo, configuration: &Configuration) -> CheckResult {
    let CameraInfo { pan_speed_min, pan_speed_max, tilt_speed_min, tilt_speed_max } = *info;
    let speeds = format!(
        "pan {pan_speed_min} to {pan_speed_max} deg/s, tilt {tilt_speed_min} to {tilt_speed_max} deg/s"
    );
    let camera = &configuration.profile.camera;
    let is_below =
        |axis: &AxisDynamics, least: f64| axis.min_rate.radians_per_second().to_degrees() < least - 1e-3;
    let keys: Vec<String> = [("pan", &camera.pan, pan_speed_min), ("tilt", &camera.tilt, tilt_speed_min)]
        .into_iter()
        .filter(|(_, axis, least)| is_below(axis, *least))
        .map(|(name, _, least)| format!("camera.{name}.least_rad_per_s = {:.4}", least.to_radians()))
        .collect();
    if keys.is_empty() {
        return CheckResult::new("speeds", Verdict::Ok, speeds);
    }
    let details = format!(
        "{speeds}: slower rates are sent as 0, which the law does not expect; set {}",
        keys.join(" and ")
    );
    CheckResult::new("speeds", Verdict::Warning, details)
}

fn check_video(told: Result<Option<VehicleVideo>, String>, hosts: PermittedHosts<'_>) -> CheckResult {
    let (verdict, details) = match told {
        Err(said) => (Verdict::Failed, said),
        Ok(None) => (Verdict::Warning, "the vehicle has no video".to_owned()),
        Ok(Some(video)) => match video.address.as_deref().map(|address| named_video(address, hosts)) {
            Some(Ok(url)) => {
                let protocol = if url.tls_server().is_some() { "RTSP in TLS" } else { "RTSP" };
                let name = video.among_choices();
                (Verdict::Ok, format!("{name}, by {protocol}: `run` without --video takes it"))
            }
            Some(Err(error)) => (Verdict::Failed, format!("{error}; or give --video rtsp://...")),
            None => {
                let name = video.among_choices();
                (Verdict::Warning, format!("{name}, without an address: give --video rtsp://..."))
            }
        },
    };
    CheckResult::new("the vehicle's video", verdict, details)
}
