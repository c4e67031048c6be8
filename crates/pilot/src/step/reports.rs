//! What the vehicle reports: to the law, the net yaw and the safety rule.

use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Angle, Telemetry, Timestamp};

use super::Pilot;
use crate::object_trackers::TrackedObject;
use crate::outcome::Refusal;

impl Pilot {
    /// Passes reports of the camera on to the law, and those of the vehicle to the safety rule.
    pub(super) fn on_telemetry(&mut self, telemetry: &Telemetry) {
        self.safety.on_report(&telemetry.report);
        self.unasked_motion.on_telemetry(telemetry);
        if let Some(vessel) = &mut self.vessel {
            vessel.on_camera_report(telemetry);
        }
        match telemetry.report {
            Report::CameraTilt(tilt) => self.on_tilt(tilt, telemetry.at),
            Report::CameraHeading(heading) => {
                let pan = self.pan_at(telemetry.at);
                self.earth.on_heading(heading, pan, telemetry.at);
            }
            Report::Position { latitude, longitude, .. } => {
                self.earth.on_position(GeoPoint { latitude, longitude }, telemetry.at);
            }
            Report::FieldOfView(angle) => self.law.on_field_of_view_report(angle, telemetry.at),
            Report::OtherVideo(field_of_view) => {
                self.law.on_other_video(field_of_view, telemetry.at);
                // Another object may be where the held ones were.
                self.held_marks.trackers.iter_mut().for_each(TrackedObject::lose);
                self.history.clear();
                self.video_since = telemetry.at;
            }
            Report::GimbalAttitude(attitude) => {
                let tilt = self.settings.profile.gimbal_tilt.and_then(|convention| convention.tilt(attitude));
                if let Some(tilt) = tilt {
                    self.on_tilt(tilt, telemetry.at);
                }
            }
            Report::VehicleAttitude(attitude) => {
                let pan = self.pan_at(telemetry.at);
                self.net_yaw.on_attitude(attitude, pan);
            }
            Report::Link(LinkState::Opening) => {
                self.net_yaw.forget_reports();
                self.earth.forget();
            }
            _ => {}
        }
    }

    /// Why nothing is done with what is seen in a picture that was captured before the change of the video.
    pub(super) fn other_video(&self, captured: Timestamp) -> Option<Refusal> {
        (captured < self.video_since).then_some(Refusal::OtherVideo)
    }

    /// The vehicle tells the elevation of the camera's axis.
    fn on_tilt(&mut self, tilt: Angle, at: Timestamp) {
        let is_first = self.reported_tilt.is_none_or(|(before, _)| !before.radians().is_finite());
        self.reported_tilt = Some((tilt, at));
        if let Some(vessel) = &mut self.vessel {
            vessel.on_tilt(at);
        }
        if is_first {
            self.law.on_first_tilt_report(tilt, at);
        } else {
            self.law.on_tilt_report(tilt, at);
        }
    }
}
