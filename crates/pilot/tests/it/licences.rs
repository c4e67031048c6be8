//! Every sequence of events to a stated depth: no motion without a live link, fresh video and exactly one
//! licence.
//!
//! The safety rule is stepped through a tree of events. Beside it, [`Past`] remembers only when what
//! happened, and the rule of motion is evaluated on that past, without a state machine.

use core::time::Duration;

use barrelman_pilot::safety::{Decision, ObservationResult, Safety};
use barrelman_pilot::{CommandPath, Mode, Purpose, Refusal};
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{AngularRate, CameraCommand, CameraRequest, HoldCause, Nudge, StopCause, Timestamp};

use crate::scenes::at;

/// Events in a sequence.
const DEPTH: usize = 5;
const COAST: Duration = Duration::from_millis(250);
const BEHAVIOUR: Duration = Duration::from_millis(250);
const VIDEO: Duration = Duration::from_millis(300);

/// Milliseconds between two events, and before a late tick: less and more than each time to live.
const STEP_MS: u64 = 100;
const LATE_MS: u64 = 320;

/// Each purpose has a command of its own.
const fn command_of(purpose: Purpose) -> CameraCommand {
    let rate = AngularRate::from_radians_per_second;
    match purpose {
        Purpose::Follow => CameraCommand::turning(rate(0.3), AngularRate::ZERO),
        Purpose::Nudge => CameraCommand::turning(rate(0.1), AngularRate::ZERO),
        Purpose::Search => CameraCommand::turning(AngularRate::ZERO, rate(0.05)),
        Purpose::Calibrate => CameraCommand::turning(AngularRate::ZERO, rate(-0.05)),
    }
}

const PURPOSES: [Purpose; 4] = [Purpose::Follow, Purpose::Nudge, Purpose::Search, Purpose::Calibrate];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// A video frame with a fresh localisation.
    Fresh,
    /// A video frame without the target.
    Frame,
    Tick,
    LateTick,
    Engage,
    Disengage,
    Stop,
    Nudge,
    Select,
    Consent(Purpose),
    Propose(Purpose),
    /// The search comes to its end; accepted: the camera follows again.
    SearchEnds,
    LinkUp,
    LinkDown,
    ControlTaken,
    ControlGiven,
    Emergency,
}

const EVENTS: [Event; 19] = [
    Event::Fresh,
    Event::Frame,
    Event::Tick,
    Event::LateTick,
    Event::Engage,
    Event::Disengage,
    Event::Stop,
    Event::Nudge,
    Event::Select,
    Event::Consent(Purpose::Search),
    Event::Consent(Purpose::Calibrate),
    Event::Propose(Purpose::Search),
    Event::Propose(Purpose::Calibrate),
    Event::SearchEnds,
    Event::LinkUp,
    Event::LinkDown,
    Event::ControlTaken,
    Event::ControlGiven,
    Event::Emergency,
];

/// What happened, newest last, each with whether the request was accepted.
#[derive(Debug, Default)]
struct Past(Vec<(Timestamp, Event, bool)>);

impl Past {
    fn newest(&self, is_wanted: impl Fn(Event, bool) -> bool) -> Option<(usize, Timestamp)> {
        let index = self.0.iter().rposition(|(_, event, accepted)| is_wanted(*event, *accepted))?;
        Some((index, self.0[index].0))
    }

    fn newest_of(&self, events: &[Event]) -> Option<(usize, Timestamp, Event)> {
        let (index, at) = self.newest(|event, _| events.contains(&event))?;
        Some((index, at, self.0[index].1))
    }

    /// Commands reach a camera that may move.
    fn has_live_link(&self) -> bool {
        let newest = |events: &[Event]| self.newest_of(events).map(|(_, _, event)| event);
        let is_up = newest(&[Event::LinkUp, Event::LinkDown]) == Some(Event::LinkUp);
        // Control counts since the link came up.
        let up = self.newest_of(&[Event::LinkUp, Event::LinkDown]).map_or(0, |(index, ..)| index);
        let taken = self.newest_of(&[Event::ControlTaken, Event::ControlGiven]);
        let is_taken = taken.is_some_and(|(index, _, event)| index > up && event == Event::ControlTaken);
        is_up && !is_taken && !self.0.iter().any(|(_, event, _)| *event == Event::Emergency)
    }

    /// The licences in force: the newest consent to a purpose was not ended by a later event, and was renewed
    /// in time.
    fn licences(&self, now: Timestamp) -> Vec<Purpose> {
        PURPOSES.into_iter().filter(|purpose| self.has_licence(*purpose, now)).collect()
    }

    fn has_licence(&self, purpose: Purpose, now: Timestamp) -> bool {
        let is_consent = |event: Event| match purpose {
            Purpose::Follow => event == Event::Engage || event == Event::SearchEnds,
            Purpose::Nudge => event == Event::Nudge,
            other => event == Event::Consent(other),
        };
        let Some((consent, _)) = self.newest(|event, accepted| accepted && is_consent(event)) else {
            return false;
        };
        let ends = |(index, (_, event, accepted)): (usize, &(Timestamp, Event, bool))| match event {
            Event::Disengage | Event::Stop => true,
            Event::SearchEnds => purpose == Purpose::Search,
            Event::Engage => purpose != Purpose::Follow,
            Event::Select => purpose != Purpose::Follow,
            Event::Consent(other) => *accepted && *other != purpose,
            Event::Nudge => *accepted && purpose != Purpose::Nudge,
            Event::LinkDown => purpose != Purpose::Follow,
            // Only control that was there can be taken.
            Event::ControlTaken => purpose != Purpose::Follow || self.had_control_before(index),
            Event::Emergency => true,
            _ => false,
        };
        if self.0.iter().enumerate().skip(consent + 1).any(ends) {
            return false;
        }
        if self.0[consent].1 == Event::SearchEnds && !self.search_took_the_place_of_following(consent) {
            return false;
        }
        let (renewal, lasts) = match purpose {
            Purpose::Follow => {
                let selected = self.newest_of(&[Event::Select]).map_or(0, |(index, ..)| index);
                let look = self.newest_of(&[Event::Fresh]).filter(|(index, ..)| *index >= selected);
                (look.map(|(_, at, _)| at), COAST)
            }
            Purpose::Nudge => {
                (self.newest(|event, accepted| accepted && is_consent(event)).map(|(_, at)| at), BEHAVIOUR)
            }
            other => {
                let renews = |event: Event, accepted| {
                    accepted && (is_consent(event) || event == Event::Propose(other))
                };
                (self.newest(renews).map(|(_, at)| at), BEHAVIOUR)
            }
        };
        renewal.is_some_and(|at| now.since(at) < lasts)
    }

    /// Whether the newest search before an index began while the camera followed: the operator had engaged,
    /// and nothing ended that.
    fn search_took_the_place_of_following(&self, index: usize) -> bool {
        let is_search = |(_, event, accepted): &(Timestamp, Event, bool)| {
            *accepted && *event == Event::Consent(Purpose::Search)
        };
        let Some(search) = self.0[..index].iter().rposition(is_search) else { return false };
        let engages = |(_, event, accepted): &(Timestamp, Event, bool)| {
            *accepted && matches!(event, Event::Engage | Event::SearchEnds)
        };
        let Some(engaged) = self.0[..index].iter().rposition(engages) else { return false };
        let ends = |(_, event, _): &(Timestamp, Event, bool)| {
            matches!(event, Event::Disengage | Event::Stop | Event::Emergency)
        };
        engaged < search && !self.0[engaged..index].iter().any(ends)
    }

    fn had_control_before(&self, index: usize) -> bool {
        let relevant = [Event::LinkUp, Event::LinkDown, Event::ControlTaken, Event::ControlGiven];
        let before = self.0[..index].iter().rfind(|(_, event, _)| relevant.contains(event));
        before.is_some_and(|(_, event, _)| *event == Event::ControlGiven)
            && self.newest_before(index, &[Event::LinkUp, Event::LinkDown]) == Some(Event::LinkUp)
    }

    fn newest_before(&self, index: usize, events: &[Event]) -> Option<Event> {
        self.0[..index].iter().map(|(_, event, _)| *event).rfind(|event| events.contains(event))
    }

    fn has_video(&self, now: Timestamp) -> bool {
        let newest = self.newest_of(&[Event::Fresh, Event::Frame]);
        newest.is_some_and(|(_, at, _)| now.since(at) < VIDEO)
    }
}

/// Steps the rule with an event. Returns whether a request was accepted, and the decision.
fn step(safety: &mut Safety, event: Event, now: Timestamp) -> (bool, Decision) {
    let mut accepted = true;
    let mut observation = ObservationResult::NoObservation;
    let request = |safety: &mut Safety, request| safety.on_request(&request, now).is_ok();
    let ground = |control| Report::Ground { control, uptime_s: 100.0, battery_v: 12.0, tether_m: 1.0 };
    match event {
        Event::Fresh => {
            safety.on_video(now);
            observation = ObservationResult::Fresh(command_of(Purpose::Follow));
        }
        Event::Frame => {
            safety.on_video(now);
            observation = ObservationResult::Unusable(HoldCause::TrackLost);
        }
        Event::Tick | Event::LateTick => {}
        Event::Engage => accepted = request(safety, CameraRequest::Engage),
        Event::Disengage => accepted = request(safety, CameraRequest::Disengage),
        Event::Stop => safety.stop(StopCause::Operator),
        Event::Nudge => {
            accepted = request(safety, CameraRequest::Nudge(Nudge { pan: 1.0, tilt: 0.0, zoom: 0.0 }));
        }
        Event::Select => accepted = request(safety, CameraRequest::Deselect),
        Event::Consent(purpose) => accepted = safety.consent(purpose, now).is_ok(),
        Event::Propose(purpose) => safety.propose(purpose, command_of(purpose), now),
        Event::SearchEnds => accepted = safety.finish_search(now),
        Event::LinkUp => safety.on_report(&Report::Link(LinkState::Up)),
        Event::LinkDown => safety.on_report(&Report::Link(LinkState::Opening)),
        Event::ControlTaken => safety.on_report(&ground(ControlState::Elsewhere)),
        Event::ControlGiven => safety.on_report(&ground(ControlState::Ours)),
        Event::Emergency => safety.on_report(&Report::Flight {
            state: FlightState::Emergency,
            on_time_s: 1.0,
            backup_battery_v: 12.0,
            warnings: 0,
            is_battery_low: false,
        }),
    }
    (accepted, safety.decide(observation, now))
}

#[derive(Debug, Default)]
struct Found {
    sequences: u64,
    /// Steps in which the camera moved, by purpose.
    moved: [u64; 4],
}

/// Explores every sequence of `depth` further events.
fn explore(safety: &Safety, past: &mut Past, now_ms: u64, depth: usize, found: &mut Found) {
    if depth == 0 {
        found.sequences += 1;
        return;
    }
    for event in EVENTS {
        let mut safety = safety.clone();
        let now_ms = now_ms + if event == Event::LateTick { LATE_MS } else { STEP_MS };
        let now = at(now_ms);
        let (accepted, decision) = step(&mut safety, event, now);
        past.0.push((now, event, accepted));
        check(past, &decision, now, found);
        explore(&safety, past, now_ms, depth - 1, found);
        past.0.pop();
    }
}

/// The rule of motion, as the invariant of every step.
fn check(past: &Past, decision: &Decision, now: Timestamp, found: &mut Found) {
    let moves = !decision.command.is_rest();
    if !moves {
        return;
    }
    let licences = past.licences(now);
    let [purpose] = licences[..] else { panic!("{licences:?} move the camera: {decision:?} {past:?}") };
    assert_eq!(decision.command, command_of(purpose), "{past:?}");
    assert!(past.has_live_link(), "no live link: {decision:?} {past:?}");
    assert!(past.has_video(now), "no fresh video: {decision:?} {past:?}");
    let is_named = matches!(
        (decision.mode, purpose),
        (Mode::Servoing, Purpose::Follow)
            | (Mode::Nudging, Purpose::Nudge)
            | (Mode::Searching, Purpose::Search)
            | (Mode::Calibrating, Purpose::Calibrate)
    );
    assert!(is_named, "{decision:?} {past:?}");
    let ends = decision.wake_at.expect("a motion has an end");
    assert!(ends > now && ends <= now.plus(VIDEO), "{decision:?} {past:?}");
    found.moved[PURPOSES.iter().position(|known| *known == purpose).unwrap()] += 1;
}

/// What happens before the sequences, so that each purpose is within their reach.
const BEGINNINGS: [&[Event]; 6] = [
    &[],
    &[Event::LinkUp, Event::ControlGiven, Event::Fresh],
    &[Event::LinkUp, Event::ControlGiven, Event::Fresh, Event::Engage, Event::Fresh],
    &[Event::LinkUp, Event::Frame, Event::Consent(Purpose::Search), Event::Propose(Purpose::Search)],
    &[Event::LinkUp, Event::Fresh, Event::Consent(Purpose::Calibrate), Event::Propose(Purpose::Calibrate)],
    &[
        Event::LinkUp,
        Event::ControlGiven,
        Event::Fresh,
        Event::Engage,
        Event::Consent(Purpose::Search),
        Event::Propose(Purpose::Search),
    ],
];

#[test]
fn no_sequence_of_events_moves_the_camera_without_link_video_and_one_licence() {
    let mut found = Found::default();
    for beginning in BEGINNINGS {
        let mut safety = Safety::new(COAST, CommandPath::Link);
        let (mut past, mut now_ms) = (Past::default(), 0);
        for event in beginning {
            now_ms += STEP_MS;
            let (accepted, decision) = step(&mut safety, *event, at(now_ms));
            past.0.push((at(now_ms), *event, accepted));
            check(&past, &decision, at(now_ms), &mut found);
        }
        explore(&safety, &mut past, now_ms, DEPTH, &mut found);
    }
    assert_eq!(found.sequences, BEGINNINGS.len() as u64 * (EVENTS.len() as u64).pow(DEPTH as u32));
    assert!(found.moved.iter().all(|moved| *moved > 3_000), "each licence moves the camera: {found:?}");
}

#[test]
fn a_consent_to_search_or_to_calibrate_ends_by_itself_however_often_it_is_renewed() {
    for (purpose, lasts_s) in [(Purpose::Search, 60), (Purpose::Calibrate, 120)] {
        let mut safety = Safety::new(COAST, CommandPath::Link);
        safety.on_report(&Report::Link(LinkState::Up));
        safety.on_video(at(0));
        safety.consent(purpose, at(0)).unwrap();
        let mut moved_ms = 0;
        for ms in (0..200_000).step_by(50) {
            safety.on_video(at(ms));
            safety.propose(purpose, command_of(purpose), at(ms));
            if !safety.decide(ObservationResult::NoObservation, at(ms)).command.is_rest() {
                moved_ms = ms;
            }
        }
        assert_eq!(moved_ms, lasts_s * 1_000 - 50, "{purpose:?}");
    }
}

#[test]
fn a_search_and_a_calibration_are_held_to_the_low_rate() {
    let fast = CameraCommand::turning(AngularRate::from_radians_per_second(-2.0), AngularRate::ZERO);
    for purpose in [Purpose::Search, Purpose::Calibrate] {
        let mut safety = Safety::new(COAST, CommandPath::Link);
        safety.on_report(&Report::Link(LinkState::Up));
        safety.on_video(at(0));
        safety.consent(purpose, at(0)).unwrap();
        safety.propose(purpose, fast, at(10));
        let command = safety.decide(ObservationResult::NoObservation, at(10)).command;
        assert_eq!(command.pan.radians_per_second(), -0.1);
    }
}

#[test]
fn a_purpose_does_not_take_the_place_of_another_unless_the_operator_may_mean_it() {
    let engaged = |consents: &[Purpose]| {
        let mut safety = Safety::new(COAST, CommandPath::Simulated);
        safety.on_video(at(0));
        consents.iter().for_each(|purpose| match purpose {
            Purpose::Follow => safety.on_request(&CameraRequest::Engage, at(0)).unwrap(),
            other => safety.consent(*other, at(0)).unwrap(),
        });
        safety
    };
    let refusal = |consents: &[Purpose], purpose| engaged(consents).consent(purpose, at(10)).err();
    assert_eq!(refusal(&[], Purpose::Search), None);
    assert_eq!(
        refusal(&[Purpose::Follow], Purpose::Search),
        None,
        "the operator asks for it when the boat is lost"
    );
    assert_eq!(refusal(&[Purpose::Follow], Purpose::Calibrate), Some(Refusal::Engaged));
    assert_eq!(refusal(&[Purpose::Search], Purpose::Calibrate), Some(Refusal::Busy(Purpose::Search)));
    assert_eq!(refusal(&[Purpose::Calibrate], Purpose::Nudge), Some(Refusal::Busy(Purpose::Calibrate)));
    assert_eq!(refusal(&[Purpose::Search], Purpose::Search), None);
}

#[test]
fn a_rate_never_lasts_longer_than_half_a_second_after_the_last_look() {
    let moves_after = |ms| {
        let mut safety = Safety::new(Duration::from_secs(2), CommandPath::Link);
        safety.on_report(&Report::Link(LinkState::Up));
        safety.on_request(&CameraRequest::Engage, at(0)).unwrap();
        safety.decide(ObservationResult::Fresh(command_of(Purpose::Follow)), at(0));
        !safety.decide(ObservationResult::NoObservation, at(ms)).command.is_rest()
    };
    assert_eq!((moves_after(499), moves_after(500)), (true, false));
}
