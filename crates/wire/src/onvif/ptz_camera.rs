//! The other end: a camera with ONVIF's services, for the emulator and the tests. What moves it until when,
//! what it tells, and what it refuses.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use jiff::Timestamp as UtcTime;

use super::login::Login;
use super::velocity::{FullSpeeds, SpeedShares};
pub use answer::Answer;
use requests::{Asked, Message, Security};

mod answer;
mod replies;
mod requests;

/// A message older or newer than this on the camera's clock is refused.
const MAX_SKEW: Duration = Duration::from_secs(30);
/// The configuration of the motion of all profiles.
const CONFIGURATION: &str = "PTZ_1";

/// What an emulated camera is like.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraSettings {
    /// The login that it asks for; `None`: it asks for none.
    pub login: Option<Login>,
    /// Its base address, as it tells the addresses of its services: `http://HOST:PORT`.
    pub base: String,
    /// The address of its video.
    pub video: String,
    /// Tokens and names of the media profiles that move, the main stream first.
    pub profiles: Vec<(String, String)>,
    /// The token of their video source.
    pub source: String,
    /// The range of the time-outs that it takes.
    pub timeouts: (Duration, Duration),
    /// The ends of its ranges.
    pub full: FullSpeeds,
    /// Whether it tells its position. Many cameras do not.
    pub tells_position: bool,
    /// Whether it knows GetServices. Old cameras know GetCapabilities alone.
    pub knows_services: bool,
    /// The date on its clock at the time 0 of the program.
    pub clock: UtcTime,
}

impl CameraSettings {
    /// A camera of profile S without a login.
    pub fn example() -> Self {
        Self {
            login: None,
            base: "http://127.0.0.1".to_owned(),
            video: "rtsp://127.0.0.1/stream1".to_owned(),
            profiles: [("Profile_1", "main"), ("Profile_2", "sub")]
                .map(|(token, name)| (token.to_owned(), name.to_owned()))
                .into(),
            source: "Source_1".to_owned(),
            timeouts: (Duration::from_millis(100), Duration::from_secs(60)),
            full: FullSpeeds { zoom: Some(1.0), ..FullSpeeds::GENERIC },
            tells_position: true,
            knows_services: true,
            clock: UtcTime::UNIX_EPOCH,
        }
    }
}

/// What a camera does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CameraFaults {
    /// No motion ends by itself.
    pub ignores_timeouts: bool,
    /// Stop is answered, and changes nothing.
    pub ignores_stops: bool,
    /// A ContinuousMove of 0 is answered, and changes nothing.
    pub ignores_zeros: bool,
    /// Every login is refused.
    pub refuses_login: bool,
    /// Its clock is ahead by this many seconds from now on.
    pub clock_ahead_s: i64,
}

/// A motion.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moving {
    velocity: SpeedShares,
    until: Timestamp,
}

/// A camera.
#[derive(Debug, Clone)]
pub struct PtzCamera {
    settings: CameraSettings,
    faults: CameraFaults,
    moving: Option<Moving>,
    refusals: u64,
    stops: u64,
}

impl PtzCamera {
    /// A camera at rest.
    pub const fn new(settings: CameraSettings) -> Self {
        let faults = CameraFaults {
            ignores_timeouts: false,
            ignores_stops: false,
            ignores_zeros: false,
            refuses_login: false,
            clock_ahead_s: 0,
        };
        Self { settings, faults, moving: None, refusals: 0, stops: 0 }
    }

    /// Sets what the camera does wrong from now on.
    pub const fn set_faults(&mut self, faults: CameraFaults) {
        self.faults = faults;
    }

    /// The camera is another one from now on.
    pub fn set_settings(&mut self, settings: CameraSettings) {
        self.settings = settings;
    }

    /// What it does wrong.
    pub const fn faults(&self) -> CameraFaults {
        self.faults
    }

    /// The camera starts again: nothing moves it.
    pub const fn restart(&mut self) {
        self.moving = None;
    }

    /// The speeds at which it moves now.
    pub fn velocity(&self, now: Timestamp) -> SpeedShares {
        let is_over = |moving: &Moving| !self.faults.ignores_timeouts && now >= moving.until;
        self.moving.filter(|moving| !is_over(moving)).map_or(SpeedShares::default(), |moving| moving.velocity)
    }

    /// How many messages were refused as unusable or unknown.
    pub const fn refusals(&self) -> u64 {
        self.refusals
    }

    /// How many Stops have arrived.
    pub const fn stops(&self) -> u64 {
        self.stops
    }

    /// The login that it asks for.
    pub const fn login(&self) -> Option<&Login> {
        self.settings.login.as_ref()
    }

    /// Answers a message. `position`: where it points, -1 to 1 on both axes. `is_proved`: HTTP has proved who
    /// asks.
    pub fn answer(
        &mut self,
        message: &[u8],
        position: (f64, f64),
        is_proved: bool,
        now: Timestamp,
    ) -> Answer {
        let Some(Message { security, asked }) = requests::read(message) else {
            self.refusals += 1;
            return replies::fault(400, &["s:Sender", "ter:WellFormed"], "the message cannot be read");
        };
        if !matches!(asked, Asked::DateAndTime) && !self.admits(security.as_ref(), is_proved, now) {
            return replies::fault(
                400,
                &["s:Sender", "ter:NotAuthorized"],
                "Sender not authorized: wrong login, or a message of another time",
            );
        }
        let answer = self.reply(&asked, position, now).unwrap_or_else(|refused| refused);
        self.refusals += u64::from(answer.status != 200);
        answer
    }

    fn clock(&self, now: Timestamp) -> UtcTime {
        let running = jiff::SignedDuration::try_from(now.since(Timestamp::ZERO)).unwrap_or_default();
        let ahead = jiff::SignedDuration::from_secs(self.faults.clock_ahead_s);
        self.settings.clock.checked_add(running).and_then(|at| at.checked_add(ahead)).unwrap_or(UtcTime::MAX)
    }

    fn admits(&self, security: Option<&Security>, is_proved: bool, now: Timestamp) -> bool {
        let Some(login) = &self.settings.login else { return true };
        if self.faults.refuses_login {
            return false;
        }
        let is_right = |security: &Security| {
            let created = security.created.parse::<UtcTime>().ok();
            let skew = created.map(|created| created.duration_since(self.clock(now)).unsigned_abs());
            security.user == login.user()
                && skew.is_some_and(|skew| skew <= MAX_SKEW)
                && security.digest == login.digest(&security.nonce, &security.created)
        };
        is_proved || security.is_some_and(is_right)
    }

    fn reply(&mut self, asked: &Asked, position: (f64, f64), now: Timestamp) -> Result<Answer, Answer> {
        let CameraSettings {
            base,
            video,
            profiles,
            source,
            timeouts,
            full,
            tells_position,
            knows_services,
            ..
        } = &self.settings;
        Ok(match asked {
            Asked::DateAndTime => replies::date_and_time(self.clock(now)),
            Asked::Services if *knows_services => replies::services(base),
            Asked::Capabilities => replies::capabilities(base),
            Asked::Profiles => replies::profiles(profiles, source, CONFIGURATION),
            Asked::StreamUri { profile } => {
                self.known_profile(profile)?;
                replies::stream_uri(video)
            }
            Asked::MoveOptions { configuration } => {
                known(configuration == CONFIGURATION)?;
                replies::move_options(*full, *timeouts)
            }
            Asked::Status { profile } => {
                self.known_profile(profile)?;
                let is_moving = self.velocity(now) != SpeedShares::default();
                replies::status(tells_position.then_some(position), is_moving, self.clock(now))
            }
            Asked::Move { profile, velocity, timeout } => {
                self.known_profile(profile)?;
                self.start_moving(*velocity, *timeout, now)?;
                replies::done("ContinuousMoveResponse")
            }
            Asked::Stop { profile } => {
                self.known_profile(profile)?;
                self.stops += 1;
                if !self.faults.ignores_stops {
                    self.moving = None;
                }
                replies::done("StopResponse")
            }
            Asked::Services | Asked::Other => {
                return Err(replies::fault(
                    400,
                    &["s:Receiver", "ter:ActionNotSupported"],
                    "the camera does not know this",
                ));
            }
        })
    }

    fn known_profile(&self, token: &str) -> Result<(), Answer> {
        known(self.settings.profiles.iter().any(|(known, _)| known == token))
    }

    fn start_moving(
        &mut self,
        SpeedShares { pan, tilt, zoom }: SpeedShares,
        timeout: Option<Duration>,
        now: Timestamp,
    ) -> Result<(), Answer> {
        let CameraSettings { full, timeouts: (least, most), .. } = self.settings;
        let is_within = |value: f64, full: f64| value.abs() <= full * (1.0 + 1e-9);
        let zoom_full = full.zoom.unwrap_or(0.0);
        if !(is_within(pan, full.pan) && is_within(tilt, full.tilt) && is_within(zoom, zoom_full)) {
            let codes = ["s:Sender", "ter:InvalidArgVal", "ter:InvalidVelocity"];
            return Err(replies::fault(400, &codes, "the velocity is outside of its range"));
        }
        // Without a time-out, the camera takes its longest one.
        let timeout = timeout.unwrap_or(most);
        if !(least..=most).contains(&timeout) {
            let codes = ["s:Sender", "ter:InvalidArgVal", "ter:TimeoutNotSupported"];
            return Err(replies::fault(400, &codes, "the time-out is outside of its range"));
        }
        let zoom = full.zoom.map_or(0.0, |full| zoom / full);
        let velocity = SpeedShares { pan: pan / full.pan, tilt: tilt / full.tilt, zoom };
        if velocity == SpeedShares::default() {
            if !self.faults.ignores_zeros {
                self.moving = None;
            }
        } else {
            self.moving = Some(Moving { velocity, until: now.plus(timeout) });
        }
        Ok(())
    }
}

fn known(is_known: bool) -> Result<(), Answer> {
    if is_known {
        return Ok(());
    }
    Err(replies::fault(400, &["s:Sender", "ter:InvalidArgVal", "ter:NoProfile"], "there is no such token"))
}
