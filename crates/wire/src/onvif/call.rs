//! A request with the message that is sent.

use core::fmt;
use core::time::Duration;

use barrelman_vocab::Timestamp;
use sha2::{Digest as _, Sha256};

use super::ask::Ask;
use super::camera_time::CameraTime;
use super::joining::Paths;
use super::login::Login;
use super::soap;
use crate::http::{HttpCall, Lane, Method};

/// A request with the message that is sent.
#[derive(Clone, PartialEq)]
pub struct Call {
    /// What is asked.
    pub ask: Ask,
    path: String,
    message: String,
}

impl fmt::Debug for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.ask.fmt(f)
    }
}

impl HttpCall for Call {
    const LANES: &'static [Lane] = &[Lane::Stop, Lane::Turn, Lane::Camera, Lane::State];
    const CONTENT_TYPE: &'static str = "application/soap+xml; charset=utf-8";

    /// Commands have the shortest time: what is late has expired.
    fn timeout(lane: Lane) -> Duration {
        match lane {
            Lane::Stop | Lane::Turn => Duration::from_millis(500),
            Lane::Control | Lane::Camera | Lane::State | Lane::Socket => Duration::from_secs(2),
        }
    }

    fn method(&self) -> Method {
        Method::Post
    }

    fn path(&self) -> String {
        self.path.clone()
    }

    fn body(&self) -> Option<String> {
        Some(self.message.clone())
    }
}

/// Makes the calls of one conversation, each with a proof of who asks.
#[derive(Debug, Clone)]
pub struct Caller {
    login: Option<Login>,
    time: Option<CameraTime>,
    seed: [u8; 16],
    count: u64,
}

impl Caller {
    /// A conversation with a seed of its own, so that no nonce is used twice.
    pub const fn new(login: Option<Login>, seed: [u8; 16]) -> Self {
        Self { login, time: None, seed, count: 0 }
    }

    /// Takes the camera's time, which the proofs state.
    pub const fn set_time(&mut self, time: CameraTime) {
        self.time = Some(time);
    }

    /// A request of a service at its path. Before the camera's time is known, there is no proof.
    pub fn call(&mut self, ask: Ask, paths: &Paths, now: Timestamp) -> Call {
        let nonce = self.next_nonce();
        let proof = |login: &Login| self.time.map(|time| login.security_header(nonce, &time.text(now)));
        let header = self.login.as_ref().filter(|_| ask != Ask::DateAndTime).and_then(proof);
        let path = paths.of(ask.service()).to_owned();
        let message = soap::envelope(&header.unwrap_or_default(), &ask.body());
        Call { ask, path, message }
    }

    fn next_nonce(&mut self) -> [u8; 16] {
        self.count += 1;
        let hash = Sha256::new().chain_update(self.seed).chain_update(self.count.to_le_bytes()).finalize();
        core::array::from_fn(|at| hash[at])
    }
}
