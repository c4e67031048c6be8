//! `barrelman check` of a vehicle that is asked over HTTP: it reads states, and asks for neither control nor motion.

use barrelman_link::url::HttpAddress;
use barrelman_link_http::Inquiry;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::profile::AxisDynamics;
use barrelman_wire::fotokite_sigma::control::refusal;
use barrelman_wire::fotokite_sigma::json::{self, CameraInfo, CameraState, VideoStream};
use serde::Deserialize;

use super::check::{CheckResult, Verdict};
use crate::config::Configuration;
use crate::link::is_over_http;
use crate::secrets;

/// Who controls the vehicle.
#[derive(Debug, Deserialize)]
struct HandoffState {
    controlling_client: Option<Controlling>,
}

/// The client that controls.
#[derive(Debug, Deserialize)]
struct Controlling {
    operator_name: Option<String>,
}

/// Checks the vehicle at an address.
pub(super) fn check_over_http(
    address: &HttpAddress,
    configuration: Option<&Configuration>,
    results: &mut Vec<CheckResult>,
) {
    let subject = format!("link {address}");
    let Some(configuration) = configuration else { return };
    let profile = &configuration.profile;
    if !is_over_http(profile.protocol) {
        let details =
            format!("the vehicle {} is not asked over HTTP: give --profile fotokite-sigma", profile.name);
        results.push(CheckResult::new(subject, Verdict::Failed, details));
        return;
    }
    let opened = secrets::http_settings(address, &configuration.link_access)
        .and_then(|settings| Inquiry::open(&settings).map_err(anyhow::Error::from));
    let vehicle = match opened {
        Ok(vehicle) => vehicle,
        Err(error) => {
            results.push(CheckResult::new(subject, Verdict::Failed, format!("{error:#}")));
            return;
        }
    };
    results.push(CheckResult::new(subject, Verdict::Ok, "the vehicle answers"));
    let info: CameraInfo = match ask(&vehicle, "/v1/camera/info") {
        Ok(info) => info,
        Err(said) => {
            let subject = if said == Acceptance::TokenRefused { "token" } else { "camera" };
            results.push(CheckResult::new(subject, Verdict::Failed, said.text()));
            return;
        }
    };
    results.push(CheckResult::new("token", Verdict::Ok, "the vehicle accepts the token"));
    results.push(check_speeds(&info, configuration));
    results.push(match ask::<CameraState>(&vehicle, "/v1/camera/state") {
        Ok(state) if state.online_state.as_deref() == Some("Offline") => {
            CheckResult::new("camera", Verdict::Failed, Acceptance::NoCamera.text())
        }
        Ok(_) => CheckResult::new("camera", Verdict::Ok, "it is on line"),
        Err(said) => CheckResult::new("camera", Verdict::Failed, said.text()),
    });
    results.push(match ask::<HandoffState>(&vehicle, "/v1/handoff/state") {
        Ok(HandoffState { controlling_client: Some(client) }) => {
            let name = client.operator_name.unwrap_or_else(|| "another client".to_owned());
            let details = format!(
                "{name} controls the vehicle: `run` waits in the queue until the control is given up"
            );
            CheckResult::new("control", Verdict::Warning, details)
        }
        Ok(HandoffState { controlling_client: None }) => {
            CheckResult::new("control", Verdict::Ok, "nobody controls the vehicle")
        }
        Err(said) => CheckResult::new("control", Verdict::Failed, said.text()),
    });
    results.push(check_streams(ask(&vehicle, "/v1/videostreams")));
}

fn ask<T: for<'a> Deserialize<'a>>(vehicle: &Inquiry, path: &str) -> Result<T, Acceptance> {
    let (status, body) = vehicle.get(path).map_err(|_| Acceptance::Unanswered)?;
    match refusal(status) {
        Some(said) => Err(said),
        None => json::read(&body).ok_or(Acceptance::Fault),
    }
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

fn check_streams(streams: Result<Vec<VideoStream>, Acceptance>) -> CheckResult {
    let (verdict, details) = match &streams {
        Err(said) => (Verdict::Failed, said.text().to_owned()),
        Ok(streams) => match json::main_stream(streams) {
            None => (Verdict::Warning, "the vehicle has no video stream".to_owned()),
            Some(VideoStream { stream_id, rtsp_url: Some(_), .. }) => {
                (Verdict::Ok, format!("{stream_id}, by RTSP: `run` without --video takes it"))
            }
            Some(VideoStream { stream_id, .. }) => (
                Verdict::Warning,
                format!(
                    "{stream_id}, by RTSPS alone, which this program does not read: give --video rtsp://..."
                ),
            ),
        },
    };
    CheckResult::new("video streams", verdict, details)
}
