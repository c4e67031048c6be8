//! The emulated Fotokite Sigma.

use std::sync::mpsc::Receiver;

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_wire::fotokite_sigma::Sigma;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, SigmaSettings, View};

use super::heard::Heard;
use super::http_vehicle::{self, Answered, Answers, Request};

/// The token that the vehicle accepts.
pub(super) const TOKEN: &str = "token";

/// Starts the vehicle: its address, and what it hears.
pub(super) fn start(clock: Clock) -> Result<(String, Receiver<Heard>)> {
    let vehicle = Emulated { sigma: Sigma::new(SigmaSettings::example()), clock };
    let (host, heard) = http_vehicle::start(vehicle)?;
    Ok((format!("http://{host}"), heard))
}

struct Emulated {
    sigma: Sigma,
    clock: Clock,
}

impl Answers for Emulated {
    fn answer(&mut self, request: &Request) -> Answered {
        let Request { method, path, body, .. } = request;
        let asked = Incoming { method, path, token: Some(TOKEN), body };
        let answer = self.sigma.answer(asked, View::default(), self.clock.now());
        let yaw = self.sigma.rates(self.clock.now()).yaw.radians_per_second();
        let yaw = path.ends_with("rotate_with_speed").then_some(yaw);
        Answered { status: answer.status, body: answer.body, yaw }
    }
}
