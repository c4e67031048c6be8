//! The questions at the start: the camera's time, its services, a media profile that moves, and the limits of
//! the motion.

use core::time::Duration;

use barrelman_vocab::{Equipment, EquipmentKind, Timestamp};

use super::answers::{
    CapabilitiesBody, DateAndTimeBody, Profile, ProfilesBody, ServiceAddress, ServicesBody,
};
use super::ask::{Ask, Media, Service};
use super::camera_time::CameraTime;
use super::joining_error::{JoiningError, answer};
use super::move_limits::limits_of;
use super::refusal::Refusal;
use super::soap;
use super::velocity::FullSpeeds;

/// The path of the device's service, which the standard states.
const DEVICE_PATH: &str = "/onvif/device_service";

/// The paths of the services. The host is always that of the link, whatever the camera says.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Paths {
    media: Option<(Media, String)>,
    ptz: Option<String>,
}

impl Paths {
    /// The path of a service; before it is known, that of the device.
    pub fn of(&self, service: Service) -> &str {
        let known = match service {
            Service::Device => None,
            Service::Media(_) => self.media.as_ref().map(|(_, path)| path.as_str()),
            Service::Ptz => self.ptz.as_deref(),
        };
        known.unwrap_or(DEVICE_PATH)
    }
}

/// A media profile that moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovingProfile {
    /// Its name in requests.
    pub token: String,
    /// Its name for people.
    pub name: Option<String>,
    /// The token of the video source; `None`: not stated.
    pub source: Option<String>,
}

impl MovingProfile {
    fn of(profile: &Profile) -> Self {
        let source = profile.source().map(str::to_owned);
        Self { token: profile.token.clone(), name: profile.name.clone(), source }
    }

    /// The profile and its source, as what is used.
    pub fn equipment(&self) -> Equipment {
        let source = self.source.as_ref().map(|source| format!(" of video source {source}"));
        let name = format!("{}{}", self.token, source.unwrap_or_default());
        Equipment::new(EquipmentKind::Stream, &name)
    }
}

/// What is known of a camera that can be moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The media service.
    pub media: Media,
    /// The media profile, by its token.
    pub profile: String,
    /// All that move, in the camera's order.
    pub moving: Vec<MovingProfile>,
    /// The ends of its ranges.
    pub full: FullSpeeds,
    /// When it ends a motion by itself.
    pub timeout: Duration,
}

impl Joined {
    /// What is used of the camera.
    pub fn equipment(&self) -> Option<Equipment> {
        self.moving.iter().find(|moving| moving.token == self.profile).map(MovingProfile::equipment)
    }

    /// The question for the address of the video.
    pub fn stream_uri(&self) -> Ask {
        Ask::StreamUri { media: self.media, profile: self.profile.clone() }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Step {
    Time,
    Services,
    Capabilities,
    Profiles(Media),
    Options { media: Media, profile: String, configuration: String },
    Done(Joined),
}

/// The questions, one after the other.
#[derive(Debug, Clone)]
pub struct Joining {
    /// The media profile that the operator has chosen; `None`: the first that moves.
    chosen: Option<String>,
    moving: Vec<MovingProfile>,
    step: Step,
    paths: Paths,
    time: Option<CameraTime>,
}

impl Joining {
    /// The questions to a camera whose media profile of this token or name is to be used; `None`: the first
    /// that moves.
    pub fn new(chosen: Option<String>) -> Self {
        Self { chosen, moving: Vec::new(), step: Step::Time, paths: Paths::default(), time: None }
    }

    /// The next question; `None`: all have been answered.
    pub fn next(&self) -> Option<Ask> {
        match &self.step {
            Step::Time => Some(Ask::DateAndTime),
            Step::Services => Some(Ask::Services),
            Step::Capabilities => Some(Ask::Capabilities),
            Step::Profiles(media) => Some(Ask::Profiles(*media)),
            Step::Options { configuration, .. } => {
                Some(Ask::MoveOptions { configuration: configuration.clone() })
            }
            Step::Done(_) => None,
        }
    }

    /// Where the services are, as far as it is known.
    pub const fn paths(&self) -> &Paths {
        &self.paths
    }

    /// The camera's time, once it has told it.
    pub const fn time(&self) -> Option<CameraTime> {
        self.time
    }

    /// What is known once all questions have been answered.
    pub const fn joined(&self) -> Option<&Joined> {
        match &self.step {
            Step::Done(joined) => Some(joined),
            _ => None,
        }
    }

    /// Takes the answer to the question of [`Joining::next`].
    ///
    /// # Errors
    /// [`JoiningError`] says why the camera cannot be used. The question stands.
    pub fn on_answer(&mut self, status: u16, body: &[u8], now: Timestamp) -> Result<(), JoiningError> {
        self.step = match self.step.clone() {
            Step::Time => {
                // A camera without a time, or with a login for it, may take proofs without one (HTTP digest).
                let told = soap::read::<DateAndTimeBody>(body).map(|body| body.answer.told);
                self.time = told.and_then(|told| CameraTime::told(&told, now));
                Step::Services
            }
            Step::Services => match Refusal::of(status, body) {
                Some(refusal) if refusal.is_unknown => Step::Capabilities,
                refused => {
                    let found: ServicesBody = answer("GetServices", refused, body)?;
                    self.take_services(&found.answer.services)?
                }
            },
            Step::Capabilities => {
                let found: CapabilitiesBody = answer("GetCapabilities", Refusal::of(status, body), body)?;
                let found = &found.answer.capabilities;
                let media = found.media.as_ref().map(|media| (Media::One, &media.address));
                self.take_paths(media, found.ptz.as_ref().map(|ptz| &ptz.address))?
            }
            Step::Profiles(media) => {
                let found: ProfilesBody = answer("GetProfiles", Refusal::of(status, body), body)?;
                self.take_profiles(media, &found.answer.profiles)?
            }
            Step::Options { media, profile, .. } => {
                let (full, timeout) = limits_of(Refusal::of(status, body), body)?;
                Step::Done(Joined { media, profile, moving: self.moving.clone(), full, timeout })
            }
            done @ Step::Done(_) => done,
        };
        Ok(())
    }

    fn take_services(&mut self, services: &[ServiceAddress]) -> Result<Step, JoiningError> {
        let address_of = |service: Service| {
            let named = services.iter().find(|one| one.namespace == service.namespace());
            named.map(|one| &one.address)
        };
        let media = [Media::One, Media::Two]
            .into_iter()
            .find_map(|media| address_of(Service::Media(media)).map(|address| (media, address)));
        self.take_paths(media, address_of(Service::Ptz))
    }

    fn take_profiles(&mut self, media: Media, profiles: &[Profile]) -> Result<Step, JoiningError> {
        let moving =
            || profiles.iter().filter_map(|profile| profile.motion().map(|motion| (profile, motion)));
        self.moving = moving().map(|(profile, _)| MovingProfile::of(profile)).collect();
        let is_chosen = |profile: &Profile| self.chosen.as_deref().is_none_or(|text| profile.is_called(text));
        let used = moving().find(|(profile, _)| is_chosen(profile));
        let (profile, motion) = used.ok_or_else(|| match &self.chosen {
            Some(chosen) if !self.moving.is_empty() => {
                let moving = self.moving.iter().map(|moving| moving.token.clone()).collect();
                JoiningError::NoProfile { chosen: chosen.clone(), moving }
            }
            _ => JoiningError::NoMotion,
        })?;
        Ok(Step::Options { media, profile: profile.token.clone(), configuration: motion.to_owned() })
    }

    fn take_paths(
        &mut self,
        media: Option<(Media, &String)>,
        ptz: Option<&String>,
    ) -> Result<Step, JoiningError> {
        let (media, address) = media.ok_or(JoiningError::NoService("media"))?;
        let ptz = ptz.ok_or(JoiningError::NoService("PTZ"))?;
        self.paths = Paths { media: Some((media, path_of(address))), ptz: Some(path_of(ptz)) };
        Ok(Step::Profiles(media))
    }
}

/// The path of an address; an address that has none is a path by itself.
fn path_of(address: &str) -> String {
    let behind = address.split_once("://").map_or(address, |(_, rest)| rest);
    let path = behind.find('/').map_or("/", |at| &behind[at..]);
    // What could begin another request line is not used.
    path.chars().filter(char::is_ascii_graphic).take(256).collect()
}
