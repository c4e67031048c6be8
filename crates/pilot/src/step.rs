//! The pilot: one step for every driver.

use core::time::Duration;

use barrelman_control::{CameraLaw, LawSettings, MotorSchema, Percept, Region, Sector, Sight};
use barrelman_vision::Tracker;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{OperatorRequest, PixelBox, Telemetry, Timestamp, Track, VehicleProfile, VideoFrame};

use crate::input::Input;
use crate::outcome::{Advice, HoldCause, Notice, Outcome};
use crate::safety::{Evidence, Safety};

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
    percept: Option<Percept>,
    advice: Option<Advice>,
    last_capture: Option<Timestamp>,
}

/// What one look at the scene showed.
struct Look {
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
            percept: None,
            advice: None,
            last_capture: None,
        }
    }

    /// Takes one input and says what comes of it.
    pub fn step(&mut self, input: Input<'_>, now: Timestamp) -> Outcome {
        let look = match input {
            Input::Frame(frame) => Some(self.look_at(frame)),
            Input::Localisation(track) => {
                let captured = track.localisation().map(|seen| seen.captured);
                Some(Look { track, captured, notice: None })
            }
            Input::Request(request) => {
                self.take(&request);
                None
            }
            Input::Telemetry(telemetry) => {
                self.hear(&telemetry);
                None
            }
            Input::Tick => None,
        };
        let Some(mut look) = look else {
            return self.conclude(Evidence::NoLook, None, None, now);
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
        let evidence = self.weigh(age, now);
        self.conclude(evidence, age, look.notice, now)
    }

    fn take(&mut self, request: &OperatorRequest) {
        self.safety.request(request);
        if let OperatorRequest::Select(selection) = request {
            self.pending_selection = Some(*selection);
            self.law.forget();
        }
    }

    /// What the vehicle says of its camera is the law's affair.
    fn hear(&mut self, telemetry: &Telemetry) {
        match telemetry.report {
            Report::CameraTilt(tilt) => self.law.tilt_reported(tilt, telemetry.at),
            Report::FieldOfView(angle) => self.law.field_of_view_reported(angle, telemetry.at),
            _ => {}
        }
    }

    fn look_at(&mut self, frame: &VideoFrame) -> Look {
        let captured = Some(frame.capture.at);
        let shift = self
            .last_capture
            .filter(|last| *last <= frame.capture.at)
            .map(|last| self.law.shift(last, frame.capture.at, frame.picture.size()));
        let Some(selection) = self.pending_selection.take() else {
            return Look { track: self.tracker.track(frame, shift.as_ref()), captured, notice: None };
        };
        match self.tracker.select(frame, selection) {
            Ok(report) => Look {
                track: Track::Tracking(report.localisation),
                captured,
                notice: Some(Notice::Selected(report)),
            },
            Err(refusal) => Look {
                track: self.tracker.track(frame, shift.as_ref()),
                captured,
                notice: Some(Notice::SelectionRefused(refusal)),
            },
        }
    }

    /// What the newest look is worth as evidence for motion.
    fn weigh(&mut self, age: Option<Duration>, now: Timestamp) -> Evidence {
        let profile = &self.settings.profile;
        let looked = self.track.localisation().map(|seen| {
            let region = Region::in_picture(profile.region, seen.picture);
            let percept = Percept::new(seen.centre.in_image(seen.picture), region);
            let sight = Sight {
                percept: &percept,
                region,
                picture: seen.picture,
                captured: seen.captured,
                seen: matches!(self.track, Track::Tracking(_)),
                now,
            };
            let command = self.law.command(&sight);
            let sector = MotorSchema::released(&percept).then(|| Sector::of(percept.position));
            (percept, Advice { command, sector })
        });
        self.percept = looked.map(|(percept, _)| percept);
        self.advice = looked.map(|(_, advice)| advice);
        let stale = age.is_none_or(|age| age > profile.video_latency.saturating_add(profile.stale_after));
        let advice = self.advice.map(|advice| advice.command);
        match (self.track, advice) {
            (Track::Unseeded, _) => Evidence::Nothing(HoldCause::NoSelection),
            (Track::Lost { .. }, _) | (_, None) => Evidence::Nothing(HoldCause::TrackLost),
            _ if stale => Evidence::Nothing(HoldCause::VideoStale),
            (Track::Tracking(_), Some(wanted)) => Evidence::Fresh(wanted),
            (Track::Coasting(_), Some(wanted)) => Evidence::Coasting(wanted),
        }
    }

    fn conclude(
        &mut self,
        evidence: Evidence,
        age: Option<Duration>,
        notice: Option<Notice>,
        now: Timestamp,
    ) -> Outcome {
        let ruling = self.safety.rule(evidence, now);
        self.law.in_force(ruling.command, now);
        Outcome {
            at: now,
            mode: ruling.mode,
            track: self.track,
            age,
            percept: self.percept,
            advice: self.advice,
            command: ruling.command,
            wake_at: ruling.wake_at,
            notice,
        }
    }
}
