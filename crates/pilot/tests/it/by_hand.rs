//! Requests of a console: selections on earlier frames, nudges, changes of the law. The rule of motion is
//! explored exhaustively.

use core::time::Duration;

use barrelman_pilot::outcome::Unconfirmed;
use barrelman_pilot::{Input, LawSettings, Mode, Notice, Outcome, Pilot, PilotSettings, Refusal};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    CameraCommand, CameraRequest, DrawnSelection, HoldCause, LawId, Nudge, OperatorRequest, PixelBox,
    StopCause, Telemetry, Timestamp, Track,
};

use crate::scenes::{Answer, PICTURE, RIGHT, Scripted, at, frame, settings};

const FRAME_MS: u64 = 33;
const NUDGE_RIGHT: OperatorRequest =
    OperatorRequest::Camera(CameraRequest::Nudge(Nudge { pan: 1.0, tilt: 0.0, zoom: 0.0 }));

/// A pilot that keeps frames and whose tracker takes `selections` boxes and then gives these answers.
fn pilot(selections: usize, answers: impl IntoIterator<Item = Answer>) -> Pilot {
    let tracker = Scripted {
        tracks: answers.into_iter().collect(),
        selections: (0..selections).map(|_| Some(RIGHT)).collect(),
        ..Scripted::default()
    };
    Pilot::new(settings(), Box::new(tracker)).keeping_frames()
}

fn request(pilot: &mut Pilot, request: OperatorRequest, ms: u64) -> Outcome {
    pilot.step(Input::Request(request), at(ms))
}

/// Steps the frames `range`, each captured when it is stepped.
fn frames(pilot: &mut Pilot, range: core::ops::Range<u64>) -> Vec<Outcome> {
    range
        .map(|index| {
            let captured = at(1000 + index * FRAME_MS);
            pilot.step(Input::Frame(&frame(index, captured)), captured)
        })
        .collect()
}

/// A selection drawn on the frame of this number.
fn select_on(index: u64) -> OperatorRequest {
    let bounds = PixelBox { u: 10.0, v: 10.0, w: 20.0, h: 20.0 };
    OperatorRequest::Camera(CameraRequest::Select(DrawnSelection {
        bounds,
        captured_ns: at(1000 + index * FRAME_MS),
    }))
}

#[test]
fn a_selection_on_an_earlier_frame_is_brought_up_to_date_and_confirmed() {
    let mut pilot = pilot(1, vec![Answer::Tracking(RIGHT); 120]);
    request(&mut pilot, OperatorRequest::Camera(CameraRequest::Engage), 900);
    frames(&mut pilot, 0..31);
    let selected = request(&mut pilot, select_on(1), 2005);
    assert!(selected.is_confirming && selected.command.is_rest());
    let steps = frames(&mut pilot, 31..45);
    let confirmed = steps.iter().position(|step| matches!(step.notice, Some(Notice::SelectionConfirmed(_))));
    let confirmed = confirmed.expect("the selection is confirmed");
    assert!((3..=8).contains(&confirmed), "30 frames in steps of 12, then four frames: {confirmed}");
    for (index, step) in steps.iter().enumerate() {
        if index < confirmed {
            assert_eq!(step.mode, Mode::Holding(HoldCause::Confirming), "frame {index}");
            assert!(step.command.is_rest() && step.is_confirming);
        } else {
            assert_eq!(step.mode, Mode::Servoing, "frame {index}");
            assert!(!step.is_confirming);
        }
    }
    assert_eq!(steps[0].track, Track::Unseeded, "a track in the past is not reported");
}

#[test]
fn a_refused_selection_does_not_confirm_the_one_that_it_replaced() {
    let after = |replacement: OperatorRequest| {
        let mut pilot = pilot(1, vec![Answer::Tracking(RIGHT); 120]);
        request(&mut pilot, OperatorRequest::Camera(CameraRequest::Engage), 900);
        frames(&mut pilot, 0..60);
        let first = 1000 + 60 * FRAME_MS;
        request(&mut pilot, select_on(59), first - 5);
        assert!(frames(&mut pilot, 60..61)[0].is_confirming);
        request(&mut pilot, replacement, first + 5);
        let steps = frames(&mut pilot, 61..90);
        assert!(steps[0].notice.is_some(), "refused: {:?}", steps[0]);
        let is_at_rest = steps.iter().all(|step| step.command.is_rest());
        (is_at_rest, steps[0].track)
    };
    // Too old, and one that the tracker refuses.
    for replacement in
        [select_on(1), select_on(60), OperatorRequest::Camera(CameraRequest::SelectNext(PICTURE.bounds()))]
    {
        assert_eq!(after(replacement), (true, Track::Unseeded), "{replacement:?}");
    }
}

#[test]
fn a_refused_selection_before_the_tracker_took_the_one_of_before_keeps_the_track() {
    let mut pilot = pilot(1, vec![Answer::Tracking(RIGHT); 120]);
    request(&mut pilot, OperatorRequest::Camera(CameraRequest::Engage), 900);
    frames(&mut pilot, 0..3);
    request(&mut pilot, select_on(2), 1000 + 3 * FRAME_MS - 5);
    let steps = frames(&mut pilot, 3..60);
    assert!(steps.iter().any(|step| matches!(step.notice, Some(Notice::SelectionConfirmed(_)))));
    let next = 1000 + 60 * FRAME_MS;
    request(&mut pilot, select_on(59), next - 6);
    request(&mut pilot, select_on(1), next - 5);
    let refused = &frames(&mut pilot, 60..61)[0];
    assert!(matches!(refused.notice, Some(Notice::RequestRefused(Refusal::SelectionTooOld { .. }))));
    assert_eq!(refused.mode, Mode::Servoing);
}

#[test]
fn a_doubtful_selection_is_not_confirmed() {
    let mut pilot = pilot(1, vec![Answer::Doubtful(RIGHT); 60]);
    frames(&mut pilot, 0..3);
    request(&mut pilot, select_on(1), 1080);
    let notices: Vec<_> = frames(&mut pilot, 3..25).into_iter().filter_map(|step| step.notice).collect();
    assert_eq!(notices, [Notice::SelectionUnconfirmed(Unconfirmed::NotSure)]);
}

#[test]
fn a_track_that_is_lost_on_the_way_is_given_up_and_nothing_is_followed() {
    let answers = [vec![Answer::Tracking(RIGHT); 5], vec![Answer::Lost; 60]].concat();
    let mut pilot = pilot(1, answers);
    // Frames without a target take no answers of the script: they are stepped before the selection.
    let mut before = frames(&mut pilot, 0..1);
    assert_eq!(
        before.pop().map(|step| step.track),
        Some(Track::Tracking(crate::scenes::seen(RIGHT, at(1000))))
    );
    frames(&mut pilot, 1..3);
    request(&mut pilot, select_on(0), 1070);
    let steps = frames(&mut pilot, 3..5);
    let given_up = steps.iter().find(|step| matches!(step.notice, Some(Notice::SelectionUnconfirmed(_))));
    let given_up = given_up.expect("the selection is given up");
    assert_eq!(given_up.track, Track::Unseeded);
    assert!(!given_up.is_confirming);
}

#[test]
fn a_selection_on_a_frame_that_is_not_kept_is_refused_and_the_track_goes_on() {
    let mut pilot = pilot(1, vec![Answer::Tracking(RIGHT); 80]);
    frames(&mut pilot, 0..60);
    request(&mut pilot, select_on(2), 3000);
    let step = frames(&mut pilot, 60..61).remove(0);
    let refused = step.notice.expect("a notice");
    assert!(matches!(refused, Notice::RequestRefused(Refusal::SelectionTooOld { .. })), "{refused}");
    assert!(matches!(step.track, Track::Tracking(_)));
}

#[test]
fn what_was_drawn_before_the_change_of_the_video_is_refused() {
    let mut pilot = pilot(1, vec![Answer::Tracking(RIGHT); 40]);
    frames(&mut pilot, 0..10);
    let changed = at(1000 + 10 * FRAME_MS);
    let report = Report::OtherVideo(None);
    pilot.step(Input::Telemetry(Telemetry { at: changed, report }), changed);
    frames(&mut pilot, 13..15);
    let old = request(&mut pilot, select_on(9), 1500);
    assert_eq!(old.notice, Some(Notice::RequestRefused(Refusal::OtherVideo)));
    frames(&mut pilot, 16..17);
    let new = request(&mut pilot, select_on(14), 1530);
    assert_eq!(new.notice, None);
    assert!(frames(&mut pilot, 17..18)[0].is_confirming);
}

#[test]
fn a_nudge_moves_a_disengaged_camera_for_a_quarter_of_a_second() {
    let mut pilot = pilot(0, []);
    frames(&mut pilot, 0..1);
    let nudged = request(&mut pilot, NUDGE_RIGHT, 1010);
    assert_eq!(nudged.mode, Mode::Nudging);
    assert!((nudged.command.pan.radians_per_second() - 0.1).abs() < 1e-12);
    assert_eq!(nudged.wake_at, Some(at(1260)));
    assert_eq!(pilot.step(Input::Tick, at(1259)).mode, Mode::Nudging);
    let ended = pilot.step(Input::Tick, at(1260));
    assert_eq!((ended.mode, ended.command), (Mode::Idle, CameraCommand::REST));
}

#[test]
fn a_nudge_is_refused_while_engaged_stopped_or_blind() {
    let refused = |pilot: &mut Pilot, ms| match request(pilot, NUDGE_RIGHT, ms) {
        Outcome { notice: Some(Notice::RequestRefused(why)), command, .. } if command.is_rest() => Some(why),
        _ => None,
    };
    let mut blind = pilot(0, []);
    assert_eq!(refused(&mut blind, 1000), Some(Refusal::NoFreshVideo));
    frames(&mut blind, 0..1);
    assert_eq!(refused(&mut blind, 5000), Some(Refusal::NoFreshVideo), "the video has stopped");
    request(&mut blind, OperatorRequest::Camera(CameraRequest::Engage), 5001);
    assert_eq!(refused(&mut blind, 5002), Some(Refusal::Engaged));
    request(&mut blind, OperatorRequest::Stop(StopCause::Operator), 5003);
    assert_eq!(refused(&mut blind, 5004), Some(Refusal::Stopped));
}

#[test]
fn a_nudge_without_numbers_or_beyond_its_range_is_bounded() {
    let mut pilot = pilot(0, []);
    frames(&mut pilot, 0..1);
    let nudge = Nudge { pan: f64::NAN, tilt: -7.0, zoom: 0.0 };
    let command = request(&mut pilot, OperatorRequest::Camera(CameraRequest::Nudge(nudge)), 1010).command;
    assert_eq!((command.pan.radians_per_second(), command.tilt.radians_per_second()), (0.0, -0.1));
}

#[test]
fn the_law_changes_while_disengaged_only() {
    let mut pilot = pilot(0, []);
    let change = OperatorRequest::Camera(CameraRequest::Law { law: LawId::Eco });
    assert_eq!(request(&mut pilot, change, 10).notice, Some(Notice::LawChanged(LawId::Eco)));
    assert_eq!(pilot.law_id(), LawId::Eco);
    request(&mut pilot, OperatorRequest::Camera(CameraRequest::Engage), 20);
    let schema = OperatorRequest::Camera(CameraRequest::Law { law: LawId::Schema });
    let refused = request(&mut pilot, schema, 30).notice;
    assert_eq!(refused, Some(Notice::RequestRefused(Refusal::Engaged)));
    assert_eq!(pilot.law_id(), LawId::Eco);
}

/// What can happen, for the exhaustive search.
#[derive(Debug, Clone, Copy)]
enum Happening {
    Frame,
    LostFrame,
    Tick,
    LateTick,
    Request(OperatorRequest),
}

const DEPTH: usize = 5;

fn happenings() -> [Happening; 10] {
    use Happening::{Frame, LateTick, LostFrame, Request, Tick};
    [
        Frame,
        LostFrame,
        Tick,
        LateTick,
        Request(OperatorRequest::Camera(CameraRequest::Engage)),
        Request(OperatorRequest::Camera(CameraRequest::Disengage)),
        Request(OperatorRequest::Stop(StopCause::Operator)),
        Request(NUDGE_RIGHT),
        Request(select_on(0)),
        Request(OperatorRequest::Camera(CameraRequest::Deselect)),
    ]
}

/// What the rule of motion permits, followed beside the pilot.
#[derive(Debug, Clone, Copy, Default)]
struct Permission {
    engaged: bool,
    stopped: bool,
    fresh: Option<Timestamp>,
    nudged: Option<Timestamp>,
}

impl Permission {
    fn after(mut self, happening: Happening, outcome: &Outcome, now: Timestamp) -> Self {
        if let Happening::Request(request) = happening {
            match request {
                OperatorRequest::Camera(CameraRequest::Engage) => {
                    (self.engaged, self.stopped) = (true, false)
                }
                OperatorRequest::Camera(CameraRequest::Disengage) => {
                    (self.engaged, self.stopped) = (false, false)
                }
                OperatorRequest::Stop(_) => (self.engaged, self.stopped) = (false, true),
                OperatorRequest::Camera(CameraRequest::Select(_) | CameraRequest::Deselect) => {
                    self.fresh = None;
                }
                _ => {}
            }
            let is_nudge = matches!(request, OperatorRequest::Camera(CameraRequest::Nudge(_)));
            self.nudged = (is_nudge && !self.engaged && !self.stopped).then_some(now);
        }
        if matches!(happening, Happening::Frame) && !outcome.is_confirming {
            self.fresh = Some(now);
        }
        self
    }

    fn permits_motion(self, now: Timestamp) -> bool {
        let lasts = |since: Option<Timestamp>| {
            since.is_some_and(|since| now.since(since) < Duration::from_millis(250))
        };
        (self.engaged && lasts(self.fresh)) || (!self.engaged && !self.stopped && lasts(self.nudged))
    }
}

#[test]
fn no_sequence_of_events_moves_the_camera_without_a_licence() {
    let happenings = happenings();
    let mut sequences = 0_u32;
    let mut moving = 0_u32;
    for code in 0..happenings.len().pow(DEPTH as u32) {
        let mut pilot = pilot(DEPTH, vec![]);
        // The first frame is lost: the pilot has seen video, and follows nothing.
        pilot.step(Input::Frame(&frame(0, at(1000))), at(1000));
        let (mut now_ms, mut index, mut permission) = (1000, 0, Permission::default());
        let mut rest = code;
        for _ in 0..DEPTH {
            let happening = happenings[rest % happenings.len()];
            rest /= happenings.len();
            now_ms += if matches!(happening, Happening::LateTick) { 300 } else { FRAME_MS };
            let now = at(now_ms);
            let outcome = match happening {
                Happening::Frame => {
                    index += 1;
                    pilot.step(Input::Localisation(Track::Tracking(crate::scenes::seen(RIGHT, now))), now)
                }
                Happening::LostFrame => {
                    index += 1;
                    pilot.step(Input::Frame(&frame(index, now)), now)
                }
                Happening::Tick | Happening::LateTick => pilot.step(Input::Tick, now),
                Happening::Request(request) => pilot.step(Input::Request(request), now),
            };
            permission = permission.after(happening, &outcome, now);
            let moves = !outcome.command.is_rest();
            moving += u32::from(moves);
            assert!(
                !moves || permission.permits_motion(now),
                "{code}: {happening:?} {permission:?} {outcome:?}"
            );
            if let Happening::Request(OperatorRequest::Stop(_)) = happening {
                assert!(outcome.command.is_rest());
            }
        }
        sequences += 1;
    }
    assert_eq!(sequences, 100_000);
    assert!(moving > 10_000, "the search reaches motion: {moving}");
}

#[test]
fn settings_name_their_law() {
    let law = |law| Pilot::new(PilotSettings { law, ..settings() }, Box::new(Scripted::default())).law_id();
    assert_eq!(law(LawSettings::MotorSchema), LawId::Schema);
}
