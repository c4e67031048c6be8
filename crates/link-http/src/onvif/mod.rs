//! How an ONVIF camera is reached: whether it is there, and what it says of itself.

pub mod discovery;

use std::io;

use barrelman_host::clock::Clock;
use barrelman_link::port::PortError;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::{Named as _, Timestamp};
use barrelman_wire::onvif::JoiningError;
use barrelman_wire::onvif::answers::StreamUriBody;
use barrelman_wire::onvif::call::Caller;
use barrelman_wire::onvif::joining::{Joined, Joining, Paths};
use barrelman_wire::onvif::refusal::Refusal;
use barrelman_wire::onvif::{Ask, OnvifSettings, soap};
use ring::rand::{SecureRandom as _, SystemRandom};

use crate::authorization::Authorization;
use crate::connection::Asked;
use crate::inquiry::{Inquiry, not_usable, reason};
use crate::named_video::VehicleVideo;
use crate::settings::HttpSettings;

/// A camera that was reached, and answers what a link needs.
pub struct Camera {
    inquiry: Inquiry,
    caller: Caller,
    joining: Joining,
    joined: Joined,
    clock: Clock,
}

impl Camera {
    /// Reaches the camera and puts a link's questions to it. Nothing is moved.
    ///
    /// # Errors
    /// If the camera cannot be reached, refuses the login, or cannot be moved.
    pub fn reach(settings: &HttpSettings, onvif: &OnvifSettings) -> Result<Self, PortError> {
        let fails = |reason: String| not_usable(settings, reason);
        let inquiry = reach(settings, onvif)?;
        let clock = Clock::start();
        let mut caller = Caller::new(onvif.login.clone(), seed().map_err(|error| fails(error.to_string()))?);
        let mut joining = Joining::new(onvif.profile.clone());
        while let Some(ask) = joining.next() {
            let call = caller.call(ask, joining.paths(), clock.now());
            let (status, body) = inquiry.ask(&Asked::from(&call)).map_err(|error| fails(reason(&error)))?;
            joining.on_answer(status, &body, clock.now()).map_err(|error| fails(with_remedy(&error)))?;
            if let Some(time) = joining.time() {
                caller.set_time(time);
            }
        }
        let joined = joining.joined().cloned().ok_or_else(|| fails("the camera tells nothing".to_owned()))?;
        Ok(Self { inquiry, caller, joining, joined, clock })
    }

    /// What is known of it.
    pub const fn joined(&self) -> &Joined {
        &self.joined
    }

    /// The video of the profile that is moved.
    ///
    /// # Errors
    /// What the camera says instead.
    pub fn video(mut self) -> Result<VehicleVideo, JoiningError> {
        let question = "GetStreamUri";
        let unreadable = || JoiningError::Unreadable(question);
        let call = self.caller.call(self.joined.stream_uri(), self.joining.paths(), self.clock.now());
        let (status, body) = self.inquiry.ask(&Asked::from(&call)).map_err(|_| unreadable())?;
        if let Some(refusal) = Refusal::of(status, &body) {
            return Err(JoiningError::Refused { question, refusal });
        }
        let answer: StreamUriBody = soap::read(&body).ok_or_else(unreadable)?;
        let Joined { profile, moving, .. } = self.joined;
        let choices = moving.into_iter().map(|moving| moving.token).collect();
        Ok(VehicleVideo { name: profile, address: answer.answer.address(), choices })
    }
}

/// An error with what the operator can do, where the login is at fault.
fn with_remedy(error: &JoiningError) -> String {
    match error.said() {
        said @ Acceptance::LoginRefused => format!("{error}. {}", said.text()),
        _ => error.to_string(),
    }
}

/// Reaches the camera: it answers the question for its time.
pub(crate) fn reach(settings: &HttpSettings, onvif: &OnvifSettings) -> Result<Inquiry, PortError> {
    let authorization = onvif.login.clone().map_or(Authorization::None, Authorization::Digest);
    let inquiry = Inquiry::new(settings, authorization)?;
    let call = Caller::new(None, [0; 16]).call(Ask::DateAndTime, &Paths::default(), Timestamp::ZERO);
    inquiry.ask(&Asked::from(&call)).map_err(|error| not_usable(settings, reason(&error)))?;
    Ok(inquiry)
}

/// What the nonces of a conversation are made of.
pub(crate) fn seed() -> io::Result<[u8; 16]> {
    let mut seed = [0; 16];
    SystemRandom::new()
        .fill(&mut seed)
        .map_err(|_| io::Error::other("the system gives no random numbers"))?;
    Ok(seed)
}
