//! Snapshots, alarms and events after steps and reports that a test makes up.

use std::time::Duration;

use barrelman_pilot::outcome::Unconfirmed;
use barrelman_pilot::vessel::guiding::NoWater;
use barrelman_pilot::{Notice, Refusal, VesselOutcome};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::vehicle_text::VehicleText;
use barrelman_vocab::{
    Angle, AngularRate, Equipment, EquipmentKind, HoldCause, StopCause, Telemetry, VideoNumber,
};

use super::*;
use crate::test_scenes::{PICTURE, at, command, frame, idle, localisation};

const SERVOING: Mode = Mode::Servoing;
const HOLDING: Mode = Mode::Holding(HoldCause::Coasting);

fn publisher_with(link: LinkStatus) -> Publisher {
    Publisher::new(&VehicleProfile::fotokite_pro(), link, RecordingState::Off)
}

fn publisher() -> Publisher {
    publisher_with(LinkStatus::DryRun)
}

fn step(publisher: &mut Publisher, outcome: &Outcome) {
    publisher.on_step(&Input::Tick, outcome, VehicleRates::REST, LawId::Schema);
}

fn report(publisher: &mut Publisher, report: Report) {
    let input = Input::Telemetry(Telemetry { at: at(0), report });
    publisher.on_step(&input, &idle(at(0)), VehicleRates::REST, LawId::Schema);
}

/// The events as level, key and text.
fn events(publisher: &Publisher) -> Vec<(Level, String, String)> {
    let entries = publisher.events().subscribe().0;
    entries.into_iter().map(|entry| (entry.level, entry.key, entry.text)).collect()
}

fn keys(publisher: &Publisher) -> Vec<String> {
    events(publisher).into_iter().map(|(_, key, _)| key).collect()
}

#[test]
fn a_snapshot_holds_the_newest_step() {
    let mut publisher = publisher();
    let readers = publisher.subscribe();
    assert_eq!((readers.borrow().steps, readers.borrow().outcome.is_some()), (0, false));
    let (captured, now) = (at(100), at(300));
    let outcome = Outcome { mode: SERVOING, age: Some(Duration::from_millis(200)), ..idle(now) };
    let rates = VehicleProfile::fotokite_pro().to_vehicle(command(0.1, 0.0));
    publisher.on_step(&Input::Frame(&frame(0, captured)), &outcome, rates, LawId::Eco);
    let newest = readers.borrow().clone();
    assert_eq!((newest.steps, newest.rates, newest.law), (1, rates, Some(LawId::Eco)));
    assert_eq!(newest.outcome, Some(outcome));
    assert_eq!(newest.video.frame, Some((captured, PICTURE)));
    assert_eq!(newest.video.age, Some(Duration::from_millis(200)));
    step(&mut publisher, &idle(at(400)));
    assert_eq!(readers.borrow().video.frame, Some((captured, PICTURE)), "a tick brings no frame");
}

#[test]
fn late_video_is_an_alarm_whether_engaged_or_not_and_is_logged_once() {
    let mut publisher = publisher();
    let readers = publisher.subscribe();
    for by_ms in [1500, 2000, 3000] {
        let timing = VideoTiming::Late { by: Duration::from_millis(by_ms), since: at(0) };
        publisher.set_video_timing(VideoNumber::First, timing, at(by_ms));
    }
    let newest = readers.borrow().clone();
    assert_eq!(newest.alarms, [Alarm::StaleVideo]);
    let text = newest.video.source.timing_text.as_deref().unwrap();
    assert!(text.starts_with("video 3.0 s late since ") && text.ends_with("; reconnect"), "{text}");
    publisher.set_video_timing(VideoNumber::First, VideoTiming::InTime, at(4000));
    assert_eq!(readers.borrow().alarms, []);
    assert_eq!(readers.borrow().video.source.timing_text, None);
    assert_eq!(keys(&publisher), ["video-timing", "stale-video", "video-timing"]);
}

#[test]
fn steps_are_numbered_and_a_reader_gets_the_newest() {
    let mut publisher = publisher();
    let mut reader = publisher.subscribe();
    let mut seen = Vec::new();
    for count in [1, 1, 5, 100] {
        for _ in 0..count {
            step(&mut publisher, &idle(at(0)));
        }
        assert!(reader.has_changed().unwrap());
        seen.push(reader.borrow_and_update().steps);
        assert!(!reader.has_changed().unwrap(), "each snapshot is read once");
    }
    assert_eq!(seen, [1, 2, 7, 107]);
}

#[test]
fn readers_share_one_snapshot_and_a_reader_that_is_gone_changes_nothing() {
    let mut publisher = publisher();
    let readers: Vec<_> = (0..20).map(|_| publisher.subscribe()).collect();
    step(&mut publisher, &idle(at(0)));
    let kept = readers[0].borrow().clone();
    for reader in &readers {
        assert!(Arc::ptr_eq(&reader.borrow(), &kept), "nothing is copied for a reader");
    }
    drop(readers);
    step(&mut publisher, &idle(at(0)));
    assert_eq!(Arc::strong_count(&kept), 1, "an old snapshot lives as long as its reader keeps it");
    assert_eq!(kept.steps, 1, "a snapshot does not change");
    assert_eq!(publisher.subscribe().borrow().steps, 2, "a late reader gets the newest at once");
}

#[test]
fn the_end_of_the_publisher_ends_its_readers() {
    let publisher = publisher();
    let (reader, events) = (publisher.subscribe(), publisher.events());
    drop(publisher);
    assert!(reader.has_changed().is_err());
    assert!(events.subscribe().0.is_empty(), "the log outlives the publisher");
}

#[test]
fn dropped_frames_and_taken_stops_are_published_with_the_next_step() {
    let mut publisher = publisher();
    let reader = publisher.subscribe();
    publisher.set_dropped(3);
    publisher.set_stops_taken(2);
    assert_eq!((reader.borrow().video.dropped, reader.borrow().stops_taken), (0, 0));
    step(&mut publisher, &idle(at(0)));
    assert_eq!((reader.borrow().video.dropped, reader.borrow().stops_taken), (3, 2));
}

#[test]
fn the_frame_rate_begins_again_with_each_drive() {
    let mut publisher = publisher();
    let add = |publisher: &mut Publisher, ms| {
        publisher.on_step(&Input::Frame(&frame(0, at(ms))), &idle(at(ms)), VehicleRates::REST, LawId::Schema);
    };
    (0..100).for_each(|index| add(&mut publisher, 5000 + 40 * index));
    // 51 frames in a window of two seconds.
    assert_eq!(publisher.newest().video.fps, 25.5);
    publisher.begin_drive(&VehicleProfile::fotokite_pro(), at(0));
    assert_eq!(publisher.newest().video.fps, 0.0);
    (0..=50).for_each(|index| add(&mut publisher, 40 * index));
    assert_eq!(publisher.newest().video.fps, 25.5);
}

#[test]
fn a_new_drive_is_told_and_shows_nothing_of_the_drive_before() {
    let mut publisher = publisher();
    let world = |scenario: &str| WorldState { scenario: scenario.to_owned(), seed: 2, boat: None };
    publisher.set_world(world("open"), at(0));
    assert!(publisher.events().subscribe().0.iter().all(|entry| entry.key != "new-drive"));
    publisher.set_boat(Some(PixelBox { u: 1.0, v: 2.0, w: 3.0, h: 4.0 }));
    let found = localisation(at(5000));
    step(&mut publisher, &Outcome { mode: Mode::Servoing, track: Track::Tracking(found), ..idle(at(5000)) });
    assert_eq!(publisher.newest().world.as_ref().unwrap().boat, Some([1.0, 2.0, 3.0, 4.0]));
    publisher.begin_drive(&VehicleProfile::fotokite_pro(), at(0));
    publisher.begin_world(world("rescue"), at(0));
    let newest = publisher.newest();
    assert!(newest.outcome.is_none() && newest.boat.is_none());
    assert_eq!(newest.world, Some(world("rescue")));
    let (entries, _) = publisher.events().subscribe();
    let told = entries.iter().find(|entry| entry.key == "new-drive").unwrap();
    assert!(told.text.starts_with("new drive: rescue, seed 2: the camera is disengaged"), "{}", told.text);
}

/// What a test does to a publisher.
type Change = dyn Fn(&mut Publisher);

/// These changes raise these alarms.
#[track_caller]
fn check_alarms(link: LinkStatus, changes: &[&Change], expected: &[Alarm]) {
    let mut publisher = publisher_with(link);
    for change in changes {
        change(&mut publisher);
    }
    assert_eq!(publisher.subscribe().borrow().alarms, expected);
}

fn in_mode(mode: Mode) -> impl Fn(&mut Publisher) {
    move |publisher| step(publisher, &Outcome { mode, ..idle(at(0)) })
}

fn with_track(track: Track) -> impl Fn(&mut Publisher) {
    move |publisher| step(publisher, &Outcome { track, ..idle(at(0)) })
}

fn with_report(of: Report) -> impl Fn(&mut Publisher) {
    move |publisher| report(publisher, of)
}

fn with_video(state: VideoSourceState) -> impl Fn(&mut Publisher) {
    move |publisher| publisher.set_video(VideoNumber::First, state.clone(), at(0))
}

fn console_lost(is_lost: bool) -> impl Fn(&mut Publisher) {
    move |publisher| publisher.set_console_lost(is_lost, at(0))
}

const DRY: LinkStatus = LinkStatus::DryRun;
const LOST: Track = Track::Lost { since: Timestamp::ZERO, confidence: 0.0 };

#[test]
fn alarms_of_the_track_and_the_video() {
    check_alarms(DRY, &[], &[]);
    check_alarms(DRY, &[&in_mode(Mode::Idle)], &[]);
    check_alarms(DRY, &[&with_track(LOST)], &[Alarm::TrackLost]);
    check_alarms(DRY, &[&with_track(LOST), &with_track(Track::Unseeded)], &[]);
    check_alarms(DRY, &[&with_track(Track::Tracking(localisation(at(0))))], &[]);
    check_alarms(DRY, &[&with_track(Track::Coasting(localisation(at(0))))], &[]);
    check_alarms(DRY, &[&in_mode(Mode::Holding(HoldCause::VideoStale))], &[Alarm::StaleVideo]);
    check_alarms(DRY, &[&in_mode(Mode::Holding(HoldCause::VideoSilent))], &[Alarm::NoVideo]);
    for cause in [HoldCause::NoSelection, HoldCause::TrackLost, HoldCause::Coasting, HoldCause::Confirming] {
        check_alarms(DRY, &[&in_mode(Mode::Holding(cause))], &[]);
    }
    let lost = with_video(VideoSourceState::Lost("timeout".to_owned()));
    check_alarms(DRY, &[&lost], &[Alarm::NoVideo]);
    check_alarms(DRY, &[&lost, &in_mode(Mode::Holding(HoldCause::VideoSilent))], &[Alarm::NoVideo]);
    check_alarms(DRY, &[&lost, &with_video(VideoSourceState::Up)], &[]);
    check_alarms(DRY, &[&with_video(VideoSourceState::Connecting)], &[]);
    check_alarms(DRY, &[&with_video(VideoSourceState::Ended)], &[]);
}

fn ground(control: ControlState) -> Report {
    Report::Ground { control, uptime_s: 0.0, battery_v: 15.0, tether_m: 0.0 }
}

fn flight(state: FlightState) -> Report {
    Report::Flight { state, on_time_s: 0.0, backup_battery_v: 8.0, warnings: 0, is_battery_low: false }
}

#[test]
fn alarms_of_the_vehicle_and_its_link() {
    check_alarms(LinkStatus::Simulated, &[], &[]);
    for (state, expected) in [
        (LinkState::Opening, &[Alarm::LinkDown][..]),
        (LinkState::Starting, &[Alarm::LinkDown]),
        (LinkState::Up, &[]),
        (LinkState::Closing, &[Alarm::LinkDown]),
        (LinkState::Closed, &[Alarm::LinkDown]),
    ] {
        check_alarms(LinkStatus::Link(LinkState::Opening), &[&with_report(Report::Link(state))], expected);
    }
    let not_ours = with_report(ground(ControlState::Elsewhere));
    check_alarms(DRY, &[&not_ours], &[Alarm::ControlLost]);
    check_alarms(DRY, &[&not_ours, &with_report(ground(ControlState::Ours))], &[]);
    check_alarms(DRY, &[&not_ours, &with_report(Report::Link(LinkState::Opening))], &[Alarm::LinkDown]);
    check_alarms(DRY, &[&with_report(flight(FlightState::Emergency))], &[Alarm::Emergency]);
    let low = Report::Flight {
        state: FlightState::Flying,
        on_time_s: 0.0,
        backup_battery_v: 7.0,
        warnings: 64,
        is_battery_low: true,
    };
    check_alarms(DRY, &[&with_report(low)], &[Alarm::BatteryLow]);
    check_alarms(DRY, &[&with_report(low), &with_report(flight(FlightState::Flying))], &[]);
    for state in [FlightState::Idle, FlightState::Flying, FlightState::Other(7)] {
        check_alarms(DRY, &[&with_report(flight(FlightState::Emergency)), &with_report(flight(state))], &[]);
    }
}

#[test]
fn the_camera_is_near_an_end_stop_within_three_degrees() {
    for (degrees, is_near) in [
        (-95.0, true),
        (-90.0, true),
        (-87.1, true),
        (-86.9, false),
        (-24.0, false),
        (0.0, false),
        (6.9, false),
        (7.1, true),
        (10.0, true),
    ] {
        let tilt = with_report(Report::CameraTilt(Angle::from_degrees(degrees)));
        let expected = if is_near { &[Alarm::EndStop][..] } else { &[] };
        check_alarms(DRY, &[&tilt], expected);
    }
}

#[test]
fn a_lost_page_is_an_alarm_while_the_pilot_is_engaged() {
    check_alarms(DRY, &[&console_lost(true)], &[]);
    check_alarms(DRY, &[&in_mode(SERVOING), &console_lost(true)], &[Alarm::ConsoleLost]);
    check_alarms(DRY, &[&console_lost(true), &in_mode(HOLDING)], &[Alarm::ConsoleLost]);
    check_alarms(DRY, &[&in_mode(SERVOING), &console_lost(true), &console_lost(false)], &[]);
    check_alarms(DRY, &[&in_mode(SERVOING), &console_lost(true), &in_mode(Mode::Idle)], &[]);
    check_alarms(DRY, &[&console_lost(true), &in_mode(Mode::Nudging)], &[]);
    check_alarms(DRY, &[&console_lost(true), &in_mode(Mode::Stopped(StopCause::Operator))], &[]);
}

#[test]
fn a_failed_recording_is_an_alarm_until_the_end() {
    let failed = |publisher: &mut Publisher| {
        publisher.set_recording(RecordingState::Failed("the disk is full".to_owned()), at(0));
    };
    let on = |publisher: &mut Publisher| {
        publisher.set_recording(RecordingState::On("a.mcap".to_owned()), at(0));
    };
    check_alarms(DRY, &[&on], &[]);
    check_alarms(DRY, &[&on, &failed], &[Alarm::RecordingFailed]);
    check_alarms(DRY, &[&failed, &in_mode(SERVOING)], &[Alarm::RecordingFailed]);
}

#[test]
fn several_alarms_are_in_force_at_a_time() {
    let lost = |publisher: &mut Publisher| {
        step(publisher, &Outcome { mode: SERVOING, track: LOST, ..idle(at(0)) });
    };
    let opening = LinkStatus::Link(LinkState::Opening);
    check_alarms(
        opening,
        &[&lost, &console_lost(true), &with_video(VideoSourceState::Lost(String::new()))],
        &[Alarm::TrackLost, Alarm::NoVideo, Alarm::LinkDown, Alarm::ConsoleLost],
    );
}

#[test]
fn an_alarm_is_logged_once_each_time_it_is_raised() {
    let mut publisher = publisher();
    for track in [LOST, LOST, Track::Unseeded, LOST] {
        step(&mut publisher, &Outcome { track, ..idle(at(0)) });
    }
    let raised = events(&publisher).into_iter().filter(|(level, ..)| *level == Level::Alarm);
    let expected = (Level::Alarm, "track-lost".to_owned(), "boat lost".to_owned());
    assert_eq!(raised.collect::<Vec<_>>(), [expected.clone(), expected]);
}

#[test]
fn a_recording_that_failed_is_logged_once_with_its_reason() {
    let mut publisher = publisher();
    publisher.set_recording(RecordingState::Failed("the disk is full".to_owned()), at(0));
    step(&mut publisher, &idle(at(0)));
    let expected = "recording failed: the disk is full".to_owned();
    assert_eq!(events(&publisher)[0], (Level::Alarm, "recording-failed".to_owned(), expected));
    assert_eq!(keys(&publisher), ["recording-failed", "mode"]);
}

#[test]
fn changes_of_mode_and_track_are_logged_once() {
    let mut publisher = publisher();
    let seen = localisation(at(0));
    for (mode, track) in [
        (Mode::Idle, Track::Unseeded),
        (Mode::Idle, Track::Tracking(seen)),
        (SERVOING, Track::Tracking(seen)),
        (SERVOING, Track::Tracking(seen)),
        (HOLDING, Track::Coasting(seen)),
        (Mode::Stopped(StopCause::Operator), Track::Coasting(seen)),
    ] {
        step(&mut publisher, &Outcome { mode, track, ..idle(at(0)) });
    }
    let expected = [
        (Level::Info, "mode", "disengaged"),
        (Level::Info, "track", "track: tracking"),
        (Level::Info, "mode", "servoing"),
        (Level::Warning, "mode", "holding: boat hidden"),
        (Level::Info, "track", "track: coasting"),
        (Level::Warning, "mode", "stopped: by the operator"),
    ];
    let expected = expected.map(|(level, key, text)| (level, key.to_owned(), text.to_owned()));
    assert_eq!(events(&publisher), expected);
}

#[test]
fn refusals_are_warnings_and_other_notices_are_for_the_record() {
    for (notice, level, key) in [
        (Notice::RequestRefused(Refusal::Engaged), Level::Warning, "refused"),
        (Notice::SelectionUnconfirmed(Unconfirmed::Lost), Level::Warning, "refused"),
        (Notice::SelectionConfirmed(localisation(at(0))), Level::Info, "notice"),
        (Notice::TargetRejected, Level::Info, "notice"),
        (Notice::Deselected, Level::Info, "notice"),
        (Notice::LawChanged(LawId::Eco), Level::Info, "notice"),
        (Notice::VideoClockWentBack, Level::Info, "notice"),
    ] {
        let mut publisher = publisher();
        step(&mut publisher, &Outcome { notice: Some(notice.clone()), ..idle(at(0)) });
        let last = events(&publisher).pop();
        assert_eq!(last, Some((level, key.to_owned(), notice.to_string())));
    }
}

#[test]
fn changes_of_the_link_are_logged_once() {
    let mut publisher = publisher_with(LinkStatus::Link(LinkState::Opening));
    for state in [LinkState::Opening, LinkState::Starting, LinkState::Up, LinkState::Up, LinkState::Closing] {
        report(&mut publisher, Report::Link(state));
    }
    report(&mut publisher, ground(ControlState::Ours));
    let logged = events(&publisher).into_iter().filter(|(_, key, _)| key == "link");
    let logged: Vec<_> = logged.map(|(level, _, text)| (level, text)).collect();
    let expected = [
        (Level::Warning, "link starting".to_owned()),
        (Level::Info, "link up".to_owned()),
        (Level::Warning, "link closing".to_owned()),
    ];
    assert_eq!(logged, expected);
}

#[test]
fn what_is_used_is_logged_once_and_an_exchange_as_a_warning_with_both_names() {
    let mut publisher = publisher_with(LinkStatus::Link(LinkState::Up));
    for name in ["device 1", "device 1", "device 2", "device 2"] {
        report(&mut publisher, Report::Equipment(Equipment::new(EquipmentKind::Gimbal, name)));
        report(&mut publisher, Report::Link(LinkState::Starting));
    }
    let logged = |(level, key, text): (Level, String, String)| (key == "gimbal").then_some((level, text));
    let logged: Vec<_> = events(&publisher).into_iter().filter_map(logged).collect();
    let first = (Level::Info, "the gimbal is device 1".to_owned());
    let then = (Level::Warning, "the gimbal is another one: device 2 instead of device 1".to_owned());
    assert_eq!(logged, [first, then]);
}

#[test]
fn changes_of_the_video_are_logged_once_however_often_it_fails_to_connect() {
    let mut publisher = publisher();
    let lost = |reason: &str| VideoSourceState::Lost(reason.to_owned());
    for state in [
        VideoSourceState::Up,
        VideoSourceState::Up,
        lost("timeout"),
        lost("refused"),
        lost("timeout"),
        VideoSourceState::Up,
        VideoSourceState::Ended,
        VideoSourceState::Ended,
    ] {
        publisher.set_video(VideoNumber::First, state, at(0));
    }
    let mut keys = keys(&publisher);
    keys.retain(|key| key.starts_with("video-"));
    assert_eq!(keys, ["video-up", "video-lost", "video-up", "video-ended"]);
    assert_eq!(publisher.newest().video.source.state, VideoSourceState::Ended);
}

#[test]
fn unasked_motion_is_an_alarm_as_long_as_it_lasts() {
    let turning = |rate: Option<f64>| {
        let unasked_motion = rate.map(AngularRate::from_radians_per_second);
        Outcome { unasked_motion, mode: Mode::Stopped(StopCause::Operator), ..idle(at(0)) }
    };
    let moving = |speed: Option<f64>| {
        let vessel = VesselOutcome { unasked_speed_m_per_s: speed, ..VesselOutcome::absent() };
        Outcome { vessel, ..idle(at(0)) }
    };
    for (fault, end, alarm) in [
        (turning(Some(0.33)), turning(None), Alarm::CameraTurns),
        (moving(Some(3.0)), moving(None), Alarm::BoatMoves),
    ] {
        let mut publisher = publisher();
        step(&mut publisher, &fault);
        assert_eq!(publisher.newest().alarms, [alarm]);
        let raised = (Level::Alarm, alarm.key().to_owned(), alarm.text().to_owned());
        assert!(events(&publisher).contains(&raised));
        assert!(alarm.text().contains("stop it"), "the alarm says what to do");
        step(&mut publisher, &end);
        assert!(publisher.newest().alarms.is_empty());
    }
}

#[test]
fn tilt_and_height_that_are_reported_no_more_are_forgotten() {
    let mut publisher = publisher();
    let mut after = |ms: u64, report| {
        let input = Input::Telemetry(Telemetry { at: at(ms), report });
        publisher.on_step(&input, &idle(at(ms)), VehicleRates::REST, LawId::Schema);
        let vehicle = publisher.newest().vehicle;
        (vehicle.tilt.is_some(), vehicle.altitude_m.is_some())
    };
    assert_eq!(after(0, Report::CameraTilt(Angle::ZERO)), (true, false));
    assert_eq!(after(5_000, Report::CameraHeight(20.0)), (true, true));
    assert_eq!(after(10_000, Report::CameraHeight(20.0)), (true, true));
    assert_eq!(after(10_001, Report::CameraHeight(20.0)), (false, true));
    assert_eq!(after(20_002, Report::CameraTilt(Angle::ZERO)), (true, false));
}

#[test]
fn a_boat_that_is_commanded_and_not_reached_is_an_alarm() {
    let mut publisher = publisher();
    let mut at_mode = |mode, link| {
        let input = Input::VesselTelemetry(Telemetry { at: at(0), report: Report::Link(link) });
        let vessel = VesselOutcome { mode, ..VesselOutcome::absent() };
        let outcome = Outcome { vessel, ..idle(at(0)) };
        publisher.on_step(&input, &outcome, VehicleRates::REST, LawId::Schema);
        publisher.newest().alarms.clone()
    };
    assert_eq!(at_mode(VesselMode::Neutral, LinkState::Up), []);
    assert_eq!(at_mode(VesselMode::Neutral, LinkState::Opening), [Alarm::BoatLinkDown]);
    assert_eq!(at_mode(VesselMode::Neutral, LinkState::Silent), [Alarm::BoatLinkDown]);
    assert_eq!(at_mode(VesselMode::Released, LinkState::Silent), []);
    publisher.set_boat_may_move(at(0));
    assert_eq!(publisher.newest().alarms, [Alarm::BoatMayMove]);
    let mut at_mode = |link| {
        let input = Input::VesselTelemetry(Telemetry { at: at(0), report: Report::Link(link) });
        publisher.on_step(&input, &idle(at(0)), VehicleRates::REST, LawId::Schema);
        publisher.newest().alarms.clone()
    };
    assert_eq!(at_mode(LinkState::Starting), [Alarm::BoatMayMove]);
    assert_eq!(at_mode(LinkState::Up), []);
    let links = events(&publisher).into_iter().filter(|(_, key, _)| key == "boat-link");
    let said: Vec<String> = links.map(|(_, _, text)| text).collect();
    let expected = ["link up", "link opening", "the vehicle is silent", "link starting", "link up"]
        .map(|text| format!("boat: {text}"));
    assert_eq!(said, expected);
}

#[test]
fn what_the_boat_says_is_logged_at_each_change_and_its_texts_once() {
    let mut publisher = publisher();
    let mut tell = |seconds: u64, report| {
        let input = Input::VesselTelemetry(Telemetry { at: at(1_000 * seconds), report });
        publisher.on_step(&input, &idle(at(1_000 * seconds)), VehicleRates::REST, LawId::Schema);
    };
    let said = Report::Acceptance;
    let mode = |number| Report::DriveMode(DriveMode(number));
    let text = |text: &str| Report::Text(VehicleText::of(2, text.as_bytes()));
    for (seconds, report) in [
        (0, mode(4)),
        (0, said(Acceptance::OtherClient)),
        (1, mode(4)),
        (1, said(Acceptance::OtherClient)),
        (2, mode(11)),
        (2, said(Acceptance::OtherClient)),
        (3, mode(15)),
        (3, said(Acceptance::ChecksFail)),
        (3, text("PreArm: EKF attitude is bad")),
        (4, said(Acceptance::Accepted)),
        (33, text("PreArm: EKF attitude is bad")),
        (34, said(Acceptance::Disarmed)),
        (35, mode(4)),
        (35, said(Acceptance::OtherClient)),
    ] {
        tell(seconds, report);
    }
    let logged: Vec<String> = events(&publisher)
        .into_iter()
        .filter(|(_, key, _)| key == "boat" || key == "boat-says")
        .map(|(_, _, text)| {
            text.split(':').next().unwrap_or_default().to_owned()
                + if text.contains("has left") { " (left)" } else { "" }
        })
        .collect();
    let expected = [
        "the boat is in HOLD",
        "the boat is in RTL",
        "the boat",
        "the boat says",
        "the boat takes commands",
        "the boat",
        "the boat has left the mode in which it is steered from here; the boat is in HOLD (left)",
    ];
    assert_eq!(logged, expected);
    let texts: Vec<_> = events(&publisher).into_iter().map(|(_, _, text)| text).collect();
    assert!(texts.iter().any(|text| text.contains("PreArm: EKF attitude is bad")));
    assert!(texts.iter().any(|text| text.contains("checks before arming fail")));
    assert!(texts.iter().any(|text| text == "the boat: not armed: arm it at its own ground station"));
    assert_eq!(
        publisher.newest().vessel_text.map(|(text, _)| text.to_string()).as_deref(),
        Some("PreArm: EKF attitude is bad")
    );
}

#[test]
fn a_go_in_the_picture_is_asked_about_and_told_with_keys_of_their_own() {
    let mut publisher = publisher();
    for notice in [
        Notice::RequestRefused(Refusal::PictureOnly(NoWater::NoHeight)),
        Notice::Going(Some(NoWater::NoHeight)),
        Notice::Going(None),
    ] {
        step(&mut publisher, &Outcome { notice: Some(notice), ..idle(at(0)) });
    }
    let logged: Vec<_> = events(&publisher).into_iter().map(|(level, key, _)| (level, key)).collect();
    let expected = [
        (Level::Warning, "picture-only".to_owned()),
        (Level::Warning, "notice".to_owned()),
        (Level::Info, "notice".to_owned()),
    ];
    assert!(logged.ends_with(&expected), "{logged:?}");
}
