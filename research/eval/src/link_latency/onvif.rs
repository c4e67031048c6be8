//! The emulated ONVIF camera.

use std::sync::mpsc::Receiver;

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_wire::onvif::{CameraSettings, Login, PtzCamera};

use super::heard::Heard;
use super::http_vehicle::{self, Answered, Answers, Request};
use crate::vehicle::onvif_speeds;

/// The login that the camera accepts.
pub(super) fn login() -> Login {
    Login::new("admin".to_owned(), "password".to_owned())
}

/// Starts the camera: its address, and what it hears.
pub(super) fn start(clock: Clock) -> Result<(String, Receiver<Heard>)> {
    let settings = CameraSettings { login: Some(login()), ..CameraSettings::example() };
    let (host, heard) = http_vehicle::start(Emulated { camera: PtzCamera::new(settings), clock })?;
    Ok((format!("onvif://{host}"), heard))
}

struct Emulated {
    camera: PtzCamera,
    clock: Clock,
}

impl Answers for Emulated {
    fn answer(&mut self, request: &Request) -> Answered {
        let answer = self.camera.answer(&request.body, (0.0, 0.0), false, self.clock.now());
        let pan = self.camera.velocity(self.clock.now()).pan;
        let yaw = onvif_speeds().pan.rate_at(pan).radians_per_second();
        let is_command = String::from_utf8_lossy(&request.body).contains("ContinuousMove");
        Answered { status: answer.status, body: answer.body, yaw: is_command.then_some(yaw) }
    }
}
