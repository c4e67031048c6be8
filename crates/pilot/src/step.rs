//! The pilot: one step function for live, simulated and replayed runs.

use core::time::Duration;

use barrelman_control::{CameraLaw, LawInput, LawSettings, MotorSchema, Percept, Region, Sector};
use barrelman_vision::Tracker;
use barrelman_vocab::{
    Angle, CameraCommand, HoldCause, LawId, PictureSize, PixelBox, Timestamp, Track, VehicleProfile, ZoomRate,
};

use crate::calibration::Calibration;
use crate::candidates::Candidates;
use crate::held_marks::HeldMarks;
use crate::history::FrameHistory;
use crate::input::Input;
use crate::net_yaw::{NetYaw, NetYawLevel};
use crate::on_earth::EarthReports;
use crate::opposed_motion::OpposedMotion;
use crate::outcome::{Advice, Mode, Notice, Outcome, RENEWAL_GRACE};
use crate::proposing::Proposals;
use crate::safety::{ObservationResult, Safety};
use crate::search::{LastBearing, Search};
use crate::selecting::PendingSelection;
use crate::unasked_motion::UnaskedMotion;
use crate::vehicle::CommandPath;
use crate::verification::Verification;
use crate::vessel::{VesselPilot, VesselSettings};
use crate::zooming::Zooming;

mod net_turn;
mod observing;
mod proposing;
mod reports;
mod requests;
mod searching;
mod vessel_part;
mod zooming;

/// A reported tilt holds the camera off its end stops for this time: vehicles report the tilt some times a
/// second.
const TILT_LASTS: Duration = Duration::from_secs(1);

/// Settings of a pilot.
#[derive(Debug, Clone, PartialEq)]
pub struct PilotSettings {
    /// The vehicle whose camera is moved. The pilot uses its region, rates, latency and times, but not its
    /// signs.
    pub profile: VehicleProfile,
    /// The camera law.
    pub law: LawSettings,
}

/// Joins localisation and control, one input at a time.
pub struct Pilot {
    settings: PilotSettings,
    /// The law at the start.
    first_law: LawSettings,
    tracker: Box<dyn Tracker>,
    law: CameraLaw,
    safety: Safety,
    pending_selection: Option<PixelBox>,
    drawn_selection: Option<PendingSelection>,
    history: FrameHistory,
    proposals: Proposals,
    held_marks: HeldMarks,
    candidates: Candidates,
    /// Whether candidates are shown while a target is followed.
    are_candidates_wanted: bool,
    verification: Verification,
    track: Track,
    region: Option<Region>,
    /// Size of the newest picture.
    picture: Option<PictureSize>,
    percept: Option<Percept>,
    advice: Option<Advice>,
    last_capture: Option<Timestamp>,
    /// Since when the video frames are of the video that is followed now.
    video_since: Timestamp,
    /// The tilt that was reported last, and when.
    reported_tilt: Option<(Angle, Timestamp)>,
    /// When the link rests the camera by itself, unless the pilot is stepped before.
    rested_at: Option<Timestamp>,
    opposed_motion: OpposedMotion,
    unasked_motion: UnaskedMotion,
    net_yaw: NetYaw,
    net_yaw_level: NetYawLevel,
    last_bearing: Option<LastBearing>,
    search: Option<Search>,
    calibration: Option<Calibration>,
    zooming: Option<Zooming>,
    vessel: Option<Box<VesselPilot>>,
    earth: EarthReports,
}

/// One observation of the scene: a tracked video frame, or a localisation measured elsewhere.
struct Observation {
    track: Track,
    /// Time of capture. `None` for a track without localisation that was measured elsewhere.
    captured: Option<Timestamp>,
    /// Size of the picture, under the same condition.
    picture: Option<PictureSize>,
    notice: Option<Notice>,
}

impl Pilot {
    /// A pilot without observations: disengaged, at rest.
    pub fn new(settings: PilotSettings, tracker: Box<dyn Tracker>) -> Self {
        let law = CameraLaw::new(settings.law, &settings.profile);
        Self::with_law(settings, law, tracker)
    }

    /// The same with a custom law instead of that of the settings.
    pub fn with_law(settings: PilotSettings, law: CameraLaw, tracker: Box<dyn Tracker>) -> Self {
        let zooming = Zooming::new(&settings.profile);
        Self {
            law,
            safety: Safety::new(settings.profile.coast_motion, CommandPath::Simulated),
            net_yaw: NetYaw::new(settings.profile.net_yaw, settings.profile.attitude_yaw),
            unasked_motion: UnaskedMotion::new(&settings.profile),
            first_law: settings.law,
            settings,
            tracker,
            pending_selection: None,
            drawn_selection: None,
            history: FrameHistory::default(),
            proposals: Proposals::default(),
            held_marks: HeldMarks::default(),
            candidates: Candidates::default(),
            are_candidates_wanted: false,
            verification: Verification::default(),
            track: Track::Unseeded,
            region: None,
            picture: None,
            percept: None,
            advice: None,
            last_capture: None,
            video_since: Timestamp::ZERO,
            reported_tilt: None,
            rested_at: None,
            opposed_motion: OpposedMotion::default(),
            net_yaw_level: NetYawLevel::Free,
            last_bearing: None,
            search: None,
            calibration: None,
            zooming,
            vessel: None,
            earth: EarthReports::default(),
        }
    }

    /// The same pilot, which keeps the video frames of the last 1.5 s, so that an operator can select on an
    /// earlier one.
    #[must_use]
    pub fn keeping_frames(self) -> Self {
        Self { history: FrameHistory::keeping(), ..self }
    }

    /// The same pilot, whose commands take this path instead of that to a simulated camera.
    #[must_use]
    pub fn commanding(self, path: CommandPath) -> Self {
        Self { safety: Safety::new(self.settings.profile.coast_motion, path), ..self }
    }

    /// The same pilot, which commands a vessel, too.
    #[must_use]
    pub fn with_vessel(self, settings: VesselSettings) -> Self {
        Self { vessel: Some(Box::new(VesselPilot::new(settings))), ..self }
    }

    /// The law.
    pub const fn law_id(&self) -> LawId {
        self.settings.law.id()
    }

    /// Whether a further [`Stop`](barrelman_vocab::OperatorRequest::Stop) would change nothing: the camera is
    /// stopped, the boat is stopped or not commanded, no helm is held that a stop would bar, and no first Go
    /// waits for its confirmation.
    pub fn is_at_rest_by_stop(&self) -> bool {
        self.safety.is_stopped() && self.vessel.as_ref().is_none_or(|vessel| vessel.is_at_rest_by_stop())
    }

    /// Processes one input at the time `now`.
    pub fn step(&mut self, input: Input<'_>, now: Timestamp) -> Outcome {
        if let Some(rested_at) = self.rested_at.filter(|rested_at| *rested_at < now) {
            self.law.on_command_applied(CameraCommand::REST, rested_at);
        }
        let observation = match input {
            Input::Frame(frame) => Some(self.observe_frame(frame)),
            Input::Localisation(track) => {
                let localisation = track.localisation();
                let captured = localisation.map(|measured| measured.captured);
                let picture = localisation.map(|measured| measured.picture);
                Some(Observation { track, captured, picture, notice: None })
            }
            Input::Request(request) => {
                let notice = self.on_request(&request, now);
                return self.finish_step(ObservationResult::NoObservation, None, notice, now);
            }
            Input::Telemetry(telemetry) => {
                self.on_telemetry(&telemetry);
                None
            }
            Input::VesselTelemetry(telemetry) => {
                if let Some(vessel) = &mut self.vessel {
                    vessel.on_vessel_report(&telemetry);
                }
                None
            }
            Input::Detections(detections) => {
                self.on_detections(detections);
                None
            }
            Input::Tick => None,
        };
        let Some(mut observation) = observation else {
            return self.finish_step(ObservationResult::NoObservation, None, None, now);
        };
        if let Some(captured) = observation.captured {
            let went_back = self.last_capture.is_some_and(|last| captured < last);
            if went_back && observation.notice.is_none() {
                observation.notice = Some(Notice::VideoClockWentBack);
            }
            self.last_capture = Some(captured);
        }
        self.track = observation.track;
        if let Some(picture) = observation.picture {
            self.region = Some(Region::from_shares(self.settings.profile.region, picture));
            self.picture = Some(picture);
        }
        let age = observation.captured.map(|captured| now.since(captured));
        let result = self.evaluate(age, now);
        let is_fresh = self.is_video_fresh(age);
        let ended = self.advance_search(result, now).or_else(|| self.advance_calibration(is_fresh, now));
        self.finish_step(result, age, observation.notice.or(ended), now)
    }

    /// Computes percept and advice from the newest track, and classifies the observation for the safety rule.
    fn evaluate(&mut self, age: Option<Duration>, now: Timestamp) -> ObservationResult {
        let evaluated = self.track.localisation().copied().zip(self.region).map(|(localisation, region)| {
            let percept = Percept::new(localisation.centre.in_image(localisation.picture), region);
            let destination = self.vessel.as_ref().and_then(|vessel| vessel.destination_in_picture(now));
            let input = LawInput {
                percept: &percept,
                region,
                destination: destination.map(|at| at.in_image(localisation.picture)),
                picture: localisation.picture,
                captured: localisation.captured,
                is_measured: matches!(self.track, Track::Tracking(_)),
                now,
            };
            let command = self.law.command(&input);
            let command = self.with_zoom(command, &localisation, &percept, &input);
            let sector = MotorSchema::is_released(&percept).then(|| Sector::from_point(percept.position));
            (percept, Advice { command, sector })
        });
        self.percept = evaluated.map(|(percept, _)| percept);
        self.advice = evaluated.map(|(_, advice)| advice);
        let is_stale = age.is_none() || !self.is_video_fresh(age);
        if self.is_video_fresh(age) {
            self.safety.on_video(now);
            if let Some(vessel) = &mut self.vessel {
                vessel.on_video(now);
            }
        }
        if let Some(localisation) =
            self.track.localisation().filter(|_| !is_stale && !self.verification.is_doubted())
        {
            let point = localisation.centre.in_image(localisation.picture);
            self.note_bearing(point, localisation.picture, localisation.captured);
        }
        let advised = self.advice.map(|advice| advice.command);
        match (self.track, advised) {
            _ if self.drawn_selection.is_some() => ObservationResult::Unusable(HoldCause::Confirming),
            (Track::Unseeded, _) => ObservationResult::Unusable(HoldCause::NoSelection),
            (Track::Lost { .. }, _) | (_, None) => ObservationResult::Unusable(HoldCause::TrackLost),
            _ if is_stale => ObservationResult::Unusable(HoldCause::VideoStale),
            _ if self.verification.is_doubted() => ObservationResult::Unusable(HoldCause::Doubted),
            (Track::Tracking(_), Some(command)) => ObservationResult::Fresh(command),
            (Track::Coasting(_), Some(command)) => ObservationResult::Coasting(command),
        }
    }

    /// Whether an observation of this age shows what the camera sees now. A track that was measured elsewhere
    /// has no age while the target is lost.
    fn is_video_fresh(&self, age: Option<Duration>) -> bool {
        let profile = &self.settings.profile;
        age.is_none_or(|age| age <= profile.video_latency.saturating_add(profile.stale_after))
    }

    /// What the vehicle can execute of a command.
    fn executable(&mut self, command: CameraCommand, now: Timestamp) -> CameraCommand {
        let is_current = |at: Timestamp| at <= now && now.since(at) <= TILT_LASTS;
        let tilt = self.reported_tilt.filter(|(_, at)| is_current(*at)).map(|(tilt, _)| tilt);
        let mut executable = self.settings.profile.executable(command, tilt);
        if self.no_zoom().is_some() {
            executable.zoom = ZoomRate::ZERO;
        }
        let executable = self.within_net_yaw(executable, now);
        self.safety.on_executed(executable);
        executable
    }

    /// Applies the safety rule and puts its command in force.
    fn finish_step(
        &mut self,
        result: ObservationResult,
        age: Option<Duration>,
        notice: Option<Notice>,
        now: Timestamp,
    ) -> Outcome {
        let decision = self.safety.decide(result, now);
        self.rested_at = decision.wake_at.map(|at| at.plus(RENEWAL_GRACE));
        let command = self.executable(decision.command, now);
        self.law.on_command_applied(command, now);
        self.unasked_motion.on_command(command, now);
        if decision.mode != Mode::Searching {
            self.search = None;
        }
        let net_yaw = self.net_yaw.state(self.pan_at(now));
        let has_changed = core::mem::replace(&mut self.net_yaw_level, net_yaw.level) != net_yaw.level;
        let notice = notice.or(has_changed.then_some(Notice::NetYaw(net_yaw)));
        let vessel = self.step_vessel(result, now);
        Outcome {
            at: now,
            mode: decision.mode,
            track: self.track,
            age,
            region: self.region,
            percept: self.percept,
            advice: self.advice,
            command,
            wake_at: decision.wake_at,
            is_confirming: self.drawn_selection.is_some(),
            is_doubted: self.verification.is_doubted(),
            proposal: self.proposals.standing(),
            candidates: self.candidates.shown(),
            are_candidates_wanted: self.are_candidates_wanted,
            net_yaw,
            zoom: self.zoom_state(now),
            unasked_motion: self.unasked_motion.turning().filter(|_| self.safety.path() == CommandPath::Link),
            search_refusal: self.search_refusal(now),
            vessel,
            earth: self.earth.at(now),
            notice,
        }
    }
}
