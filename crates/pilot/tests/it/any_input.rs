//! Properties that hold for any inputs in any order.

use core::time::Duration;

use barrelman_pilot::{Input, Mode, Outcome, Pilot};
use barrelman_vocab::{CameraCommand, CameraRequest, ImagePoint, OperatorRequest, StopCause, Timestamp};
use proptest::prelude::*;

use crate::scenes::{Answer, COAST_MS, FRESH_MS, INSIDE, LEFT, RIGHT, Scripted, TOP};
use crate::scenes::{SceneInput, at, frame, settings};

/// An input, and the milliseconds since the previous one; negative where a clock runs backwards.
#[derive(Debug, Clone, Copy)]
struct Step {
    after_ms: i64,
    what: What,
}

#[derive(Debug, Clone, Copy)]
enum What {
    Input(SceneInput),
    /// A frame of this age in milliseconds, and the tracker's answer.
    Frame(u64, Answer),
}

fn any_point() -> impl Strategy<Value = ImagePoint> {
    let far = (-400.0..400.0, -300.0..300.0).prop_map(|(x, y)| ImagePoint { x, y });
    let odd = (any::<f64>(), any::<f64>()).prop_map(|(x, y)| ImagePoint { x, y });
    prop_oneof![1 => Just(INSIDE), 2 => Just(RIGHT), 2 => Just(LEFT), 1 => Just(TOP), 4 => far, 1 => odd]
}

fn any_age() -> impl Strategy<Value = u64> {
    prop_oneof![6 => 0..FRESH_MS, 1 => Just(FRESH_MS), 1 => Just(FRESH_MS + 1), 1 => 0..5_000_u64]
}

fn any_answer() -> impl Strategy<Value = Answer> {
    prop_oneof![
        6 => any_point().prop_map(Answer::Tracking),
        3 => any_point().prop_map(Answer::Coasting),
        1 => Just(Answer::Lost),
        1 => Just(Answer::Unseeded),
    ]
}

fn any_cause() -> impl Strategy<Value = StopCause> {
    prop_oneof![
        Just(StopCause::Operator),
        Just(StopCause::Ending),
        Just(StopCause::VideoEnded),
        Just(StopCause::Fault),
    ]
}

fn any_step() -> impl Strategy<Value = Step> {
    let what = prop_oneof![
        8 => (any_point(), any_age()).prop_map(|(point, age)| What::Input(SceneInput::SeenLate(point, age))),
        3 => any_point().prop_map(|point| What::Input(SceneInput::Coasts(point))),
        8 => (any_age(), any_answer()).prop_map(|(age, answer)| What::Frame(age, answer)),
        1 => Just(What::Input(SceneInput::Lost)),
        1 => Just(What::Input(SceneInput::Unseeded)),
        2 => Just(What::Input(SceneInput::Reports)),
        4 => Just(What::Input(SceneInput::Tick)),
        1 => Just(What::Input(SceneInput::Select)),
        4 => Just(What::Input(SceneInput::Engage)),
        1 => Just(What::Input(SceneInput::Disengage)),
        1 => any_cause().prop_map(|cause| What::Input(SceneInput::Stop(cause))),
    ];
    let after_ms = prop_oneof![12 => 0_i64..60, 2 => 200_i64..260, 1 => 0_i64..2_000, 1 => -300_i64..0];
    (after_ms, what).prop_map(|(after_ms, what)| Step { after_ms, what })
}

/// A step and its outcome.
struct Taken {
    now: Timestamp,
    /// Whether the step contained a fresh localisation.
    fresh: bool,
    request: Option<OperatorRequest>,
    outcome: Outcome,
}

fn run(steps: &[Step], selections: &[Option<ImagePoint>]) -> Vec<Taken> {
    let answers = steps.iter().filter_map(|step| match step.what {
        What::Frame(_, answer) => Some(answer),
        What::Input(_) => None,
    });
    let tracker = Scripted {
        tracks: answers.collect(),
        selections: selections.iter().copied().collect(),
        ..Scripted::default()
    };
    let mut pilot = Pilot::new(settings(), Box::new(tracker));
    let mut now_ms = 0_i64;
    steps
        .iter()
        .enumerate()
        .map(|(index, step)| {
            now_ms = (now_ms + step.after_ms).max(0);
            let now = at(now_ms as u64);
            let (request, outcome) = match step.what {
                What::Input(scene_input) => {
                    let input = scene_input.input(now);
                    let request = match input {
                        Input::Request(request) => Some(request),
                        _ => None,
                    };
                    (request, pilot.step(input, now))
                }
                What::Frame(age_ms, _) => {
                    let captured = now.minus(Duration::from_millis(age_ms));
                    (None, pilot.step(Input::Frame(&frame(index as u64, captured)), now))
                }
            };
            let tracking = matches!(outcome.track, barrelman_vocab::Track::Tracking(_));
            let fresh = tracking && outcome.age.is_some_and(|age| age <= Duration::from_millis(FRESH_MS));
            Taken { now, fresh, request, outcome }
        })
        .collect()
}

fn rates(command: CameraCommand) -> [f64; 2] {
    [command.pan.radians_per_second(), command.tilt.radians_per_second()]
}

/// An outcome for comparison to the bit: NaN equals itself, and 0.0 does not equal -0.0.
fn bits(outcome: &Outcome) -> (String, [u64; 2]) {
    (format!("{outcome:?}"), rates(outcome.command).map(f64::to_bits))
}

proptest! {
    #[test]
    fn the_rule_of_motion_holds(
        steps in prop::collection::vec(any_step(), 1..120),
        selections in prop::collection::vec(prop::option::of(any_point()), 0..4),
    ) {
        let coast = Duration::from_millis(COAST_MS);
        let mut last_fresh: Option<Timestamp> = None;
        let mut engaged = false;
        let mut before = CameraCommand::REST;
        for taken in run(&steps, &selections) {
            let (now, outcome) = (taken.now, &taken.outcome);
            match taken.request {
                Some(OperatorRequest::Camera(CameraRequest::Engage)) => engaged = true,
                Some(OperatorRequest::Camera(CameraRequest::Disengage) | OperatorRequest::Stop(_)) => engaged = false,
                Some(OperatorRequest::Camera(CameraRequest::SelectNext(_))) => last_fresh = None,
                Some(_) | None => {}
            }
            if taken.fresh {
                last_fresh = Some(now);
            }
            let command = outcome.command;
            prop_assert!(command.is_rest() || outcome.mode == Mode::Servoing, "{outcome:?}");
            prop_assert!(command.is_rest() || engaged, "{outcome:?}");
            for (is, was) in rates(command).into_iter().zip(rates(before)) {
                prop_assert!(is.abs() <= 0.3, "{outcome:?}");
                let raised = is != 0.0 && (is.abs() > was.abs() || is.signum() != was.signum());
                prop_assert!(!raised || taken.fresh, "{was} became {is} without a fresh look");
            }
            if !command.is_rest() {
                prop_assert!(
                    last_fresh.is_some_and(|fresh| fresh <= now && now < fresh.plus(coast)),
                    "{outcome:?} rests on {last_fresh:?}"
                );
                let wake_at = outcome.wake_at.zip(last_fresh);
                prop_assert!(wake_at.is_some_and(|(wake, fresh)| wake > now && wake <= fresh.plus(coast)));
            }
            before = command;
        }
    }

    #[test]
    fn a_tick_at_wake_at_gives_the_zeros(steps in prop::collection::vec(any_step(), 1..40)) {
        let scene_input = |step: &Step| match step.what {
            What::Input(input) => Some((step.after_ms, input)),
            What::Frame(..) => None,
        };
        let mut pilot = crate::scenes::localisation_pilot();
        let mut now_ms = 0_i64;
        let mut wake_at = None;
        for (after_ms, input) in steps.iter().filter_map(scene_input) {
            now_ms = (now_ms + after_ms).max(0);
            wake_at = pilot.step(input.input(at(now_ms as u64)), at(now_ms as u64)).wake_at;
        }
        if let Some(wake_at) = wake_at {
            let rested = pilot.step(Input::Tick, wake_at);
            prop_assert_eq!((rested.command, rested.wake_at), (CameraCommand::REST, None));
        }
    }

    #[test]
    fn two_pilots_that_are_told_the_same_do_the_same_to_the_bit(
        steps in prop::collection::vec(any_step(), 1..80),
        selections in prop::collection::vec(prop::option::of(any_point()), 0..4),
    ) {
        let (one, other) = (run(&steps, &selections), run(&steps, &selections));
        for (one, other) in one.iter().zip(&other) {
            prop_assert_eq!(bits(&one.outcome), bits(&other.outcome));
        }
    }
}
