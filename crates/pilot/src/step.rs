//! The pilot: one step for every driver.

use core::time::Duration;

use barrelman_control::{CameraLaw, LawInput, LawSettings, MotorSchema, Percept, Region, Sector};
use barrelman_vision::Tracker;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{OperatorRequest, PixelBox, Telemetry, Timestamp, Track, VehicleProfile, VideoFrame};

use crate::input::Input;
use crate::outcome::{Advice, HoldCause, Notice, Outcome};
use crate::safety::{ObservationResult, Safety};

/// What a pilot works by.
#[derive(Debug, Clone, PartialEq)]
pub struct PilotSettings {
    /// The vehicle whose camera is moved: region, rates, latency and times come from it. Its signs are not used
    /// here.
    pub profile: VehicleProfile,
    /// The camera law.
    pub law: LawSettings,
}

/// Joins localisation and control, one input at a time.
pub struct Pilot {
    settings: PilotSettings,
    tracker: Box<dyn Tracker>,
    law: CameraLaw,
    safety: Safety,
    pending_selection: Option<PixelBox>,
    track: Track,
    region: Option<Region>,
    percept: Option<Percept>,
    advice: Option<Advice>,
    last_capture: Option<Timestamp>,
}

/// What one look at the scene showed.
struct Observation {
    track: Track,
    /// When what was seen was captured; a track without a place, measured elsewhere, does not say.
    captured: Option<Timestamp>,
    notice: Option<Notice>,
}

impl Pilot {
    /// A pilot that has seen nothing yet: disengaged, at rest.
    pub fn new(settings: PilotSettings, tracker: Box<dyn Tracker>) -> Self {
        let law = CameraLaw::new(settings.law, &settings.profile);
        Self::with_law(settings, law, tracker)
    }

    /// The same with a law of one's own in place of the settings'.
    pub fn with_law(settings: PilotSettings, law: CameraLaw, tracker: Box<dyn Tracker>) -> Self {
        Self {
            law,
            safety: Safety::new(settings.profile.coast_motion),
            settings,
            tracker,
            pending_selection: None,
            track: Track::Unseeded,
            region: None,
            percept: None,
            advice: None,
            last_capture: None,
        }
    }

    /// Takes one input and says what comes of it.
    pub fn step(&mut self, input: Input<'_>, now: Timestamp) -> Outcome {
        let look = match input {
            Input::Frame(frame) => {
                self.region = Some(Region::from_shares(self.settings.profile.region, frame.picture.size()));
                Some(self.observe_frame(frame))
            }
            Input::Localisation(track) => {
                let captured = track.localisation().map(|seen| seen.captured);
                Some(Observation { track, captured, notice: None })
            }
            Input::Request(request) => {
                self.on_request(&request);
                None
            }
            Input::Telemetry(telemetry) => {
                self.on_telemetry(&telemetry);
                None
            }
            Input::Tick => None,
        };
        let Some(mut look) = look else {
            return self.finish_step(ObservationResult::NoObservation, None, None, now);
        };
        if let Some(captured) = look.captured {
            let went_back = self.last_capture.is_some_and(|last| captured < last);
            if went_back && look.notice.is_none() {
                look.notice = Some(Notice::VideoClockWentBack);
            }
            self.last_capture = Some(captured);
        }
        self.track = look.track;
        let age = look.captured.map(|captured| now.since(captured));
        let result = self.evaluate(age, now);
        self.finish_step(result, age, look.notice, now)
    }

    fn on_request(&mut self, request: &OperatorRequest) {
        self.safety.on_request(request);
        if let OperatorRequest::Select(selection) = request {
            self.pending_selection = Some(*selection);
            self.law.reset_target();
        }
    }

    /// What the vehicle says of its camera is the law's affair.
    fn on_telemetry(&mut self, telemetry: &Telemetry) {
        match telemetry.report {
            Report::CameraTilt(tilt) => self.law.on_tilt_report(tilt, telemetry.at),
            Report::FieldOfView(angle) => self.law.on_field_of_view_report(angle, telemetry.at),
            _ => {}
        }
    }

    fn observe_frame(&mut self, frame: &VideoFrame) -> Observation {
        let captured = Some(frame.capture.at);
        let shift = self
            .last_capture
            .filter(|last| *last <= frame.capture.at)
            .map(|last| self.law.motion_prior(last, frame.capture.at, frame.picture.size()));
        let Some(selection) = self.pending_selection.take() else {
            return Observation { track: self.tracker.track(frame, shift.as_ref()), captured, notice: None };
        };
        match self.tracker.select(frame, selection) {
            Ok(report) => Observation {
                track: Track::Tracking(report.localisation),
                captured,
                notice: Some(Notice::Selected(report)),
            },
            Err(refusal) => Observation {
                track: self.tracker.track(frame, shift.as_ref()),
                captured,
                notice: Some(Notice::SelectionRefused(refusal)),
            },
        }
    }

    /// What the newest look is worth as result for motion.
    fn evaluate(&mut self, age: Option<Duration>, now: Timestamp) -> ObservationResult {
        let profile = &self.settings.profile;
        let looked = self.track.localisation().map(|seen| {
            let region = Region::from_shares(profile.region, seen.picture);
            self.region = Some(region);
            let percept = Percept::new(seen.centre.in_image(seen.picture), region);
            let input = LawInput {
                percept: &percept,
                region,
                picture: seen.picture,
                captured: seen.captured,
                is_measured: matches!(self.track, Track::Tracking(_)),
                now,
            };
            let command = self.law.command(&input);
            let sector = MotorSchema::is_released(&percept).then(|| Sector::from_point(percept.position));
            (percept, Advice { command, sector })
        });
        self.percept = looked.map(|(percept, _)| percept);
        self.advice = looked.map(|(_, advice)| advice);
        let stale = age.is_none_or(|age| age > profile.video_latency.saturating_add(profile.stale_after));
        let advice = self.advice.map(|advice| advice.command);
        match (self.track, advice) {
            (Track::Unseeded, _) => ObservationResult::Unusable(HoldCause::NoSelection),
            (Track::Lost { .. }, _) | (_, None) => ObservationResult::Unusable(HoldCause::TrackLost),
            _ if stale => ObservationResult::Unusable(HoldCause::VideoStale),
            (Track::Tracking(_), Some(wanted)) => ObservationResult::Fresh(wanted),
            (Track::Coasting(_), Some(wanted)) => ObservationResult::Coasting(wanted),
        }
    }

    fn finish_step(
        &mut self,
        result: ObservationResult,
        age: Option<Duration>,
        notice: Option<Notice>,
        now: Timestamp,
    ) -> Outcome {
        let decision = self.safety.decide(result, now);
        self.law.on_command_applied(decision.command, now);
        Outcome {
            at: now,
            mode: decision.mode,
            track: self.track,
            age,
            region: self.region,
            percept: self.percept,
            advice: self.advice,
            command: decision.command,
            wake_at: decision.wake_at,
            notice,
        }
    }
}
