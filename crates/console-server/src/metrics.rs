//! `/metrics`: the newest snapshot in the text format of Prometheus (version 0.0.4).

use std::fmt::Write as _;

use super::api::StatusSnapshot;

/// The metrics. A value that is not known is left out.
pub(super) fn metrics_text(status: &StatusSnapshot, clients: usize) -> String {
    let mut text = String::with_capacity(2048);
    let mut add = |name: &str, kind: &str, help: &str, value: Option<f64>| {
        let Some(value) = value else { return };
        // Writing into a `String` cannot fail.
        let _ = writeln!(
            text,
            "# HELP barrelman_{name} {help}\n# TYPE barrelman_{name} {kind}\nbarrelman_{name} {value}"
        );
    };
    let flag = |is_set: bool| Some(f64::from(u8::from(is_set)));
    add("steps_total", "counter", "Steps of the pilot.", Some(status.step as f64));
    add("engaged", "gauge", "1 while the pilot is engaged.", flag(status.mode.engaged));
    add("stopped", "gauge", "1 while the pilot is stopped.", flag(status.mode.name == "stopped"));
    add("tracking", "gauge", "1 while the target is measured.", flag(status.track.state == "tracking"));
    add("track_confidence", "gauge", "The tracker's confidence, 0 to 1.", status.track.confidence);
    add("p", "gauge", "P; above 1 outside of the region.", status.percept.map(|percept| percept.p));
    add("pan_rate_radians_per_second", "gauge", "Pan rate in force.", Some(status.command.pan));
    add("tilt_rate_radians_per_second", "gauge", "Tilt rate in force.", Some(status.command.tilt));
    add("video_frames_per_second", "gauge", "Video frames a second.", Some(status.video.fps));
    add(
        "video_age_seconds",
        "gauge",
        "Age of the newest video frame when the pilot had processed it.",
        status.video.age_ms.map(|ms| ms / 1e3),
    );
    add(
        "step_seconds",
        "gauge",
        "Median time for a video frame, until the rates are handed to the link.",
        status.video.step_ms.map(|ms| ms / 1e3),
    );
    add(
        "video_dropped_total",
        "counter",
        "Video frames that were replaced by newer ones.",
        Some(status.video.dropped as f64),
    );
    let is_up = matches!(status.link.state, "up" | "simulated");
    add("link_up", "gauge", "1 while commands reach the camera.", flag(is_up));
    add("recording", "gauge", "1 while a recording is written.", flag(status.recording.state == "recording"));
    add("alarms", "gauge", "Alarms in force.", Some(status.alarms.len() as f64));
    add("stops_total", "counter", "Presses of Stop that were taken.", Some(status.stops_taken as f64));
    add(
        "camera_moves_total",
        "counter",
        "Starts of a camera command from rest.",
        Some(status.work.camera.moves as f64),
    );
    add(
        "camera_travel_radians_total",
        "counter",
        "Integral of the absolute rates of both axes.",
        Some(status.work.camera.travel_rad),
    );
    add("console_clients", "gauge", "Connected pages.", Some(clients as f64));
    text
}

#[cfg(test)]
mod tests;
