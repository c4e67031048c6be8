//! The status line: its content, and an output that does not take it.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::time::Duration;

use barrelman_console_server::snapshot::{LinkStatus, RecordingState, Snapshot};
use barrelman_control::{Percept, Region};
use barrelman_host::clock::Clock;
use barrelman_pilot::{Advice, Mode, Outcome};
use barrelman_station::live::faults::FaultInjector;
use barrelman_station::live::status_line::{StatusLine, StatusOutput as _};
use barrelman_station::live::status_writer::{LineStyle, StatusWriter};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, CameraCommand, HoldCause, ImagePoint, StopCause, Track, VehicleProfile};

use crate::live_scenes::{PICTURE, at, localisation};

const NOW_MS: u64 = 10_000;
const RIGHT: CameraCommand =
    CameraCommand { pan: AngularRate::from_radians_per_second(0.3), ..CameraCommand::REST };

/// An outcome in this mode with this track, and the command that the law advises.
fn outcome(mode: Mode, track: Track, advised: Option<CameraCommand>) -> Outcome {
    let region = Region::from_shares(VehicleProfile::fotokite_pro().region, PICTURE);
    let is_moving = mode == Mode::Servoing;
    Outcome {
        mode,
        track,
        region: Some(region),
        percept: track.localisation().map(|_| Percept::new(ImagePoint { x: 96.0, y: 0.0 }, region)),
        advice: advised.map(|command| Advice { command, sector: None }),
        command: advised.filter(|_| is_moving).unwrap_or(CameraCommand::REST),
        ..Outcome::idle(at(NOW_MS))
    }
}

/// Checks the line of an outcome. `prepare` sets the rest of the content.
#[track_caller]
fn check(
    link: Option<LinkState>,
    prepare: impl FnOnce(&mut Snapshot),
    outcome: Option<&Outcome>,
    expected: &str,
) {
    let mut snapshot = Snapshot { outcome: outcome.cloned(), ..Snapshot::default() };
    snapshot.vehicle.link = link.map_or(LinkStatus::DryRun, LinkStatus::Link);
    snapshot.rates = VehicleProfile::fotokite_pro()
        .to_vehicle(outcome.map_or(CameraCommand::REST, |outcome| outcome.command));
    prepare(&mut snapshot);
    let line = StatusLine::new(Duration::from_secs(1)).next_line(&snapshot, at(NOW_MS));
    assert_eq!(line.as_deref(), Some(expected));
}

#[test]
fn each_state_has_its_line() {
    let seen = || Track::Tracking(localisation(at(9_800)));
    let coasting = Track::Coasting(localisation(at(9_800)));
    let lost = Track::Lost { since: at(7_500), confidence: 0.1 };
    let nothing = |_: &mut Snapshot| {};
    let up = Some(LinkState::Up);
    check(
        None,
        nothing,
        None,
        "waiting for video | nothing selected | P - | pan +0.00 tilt +0.00 rad/s (not sent) | dry run | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Idle, Track::Unseeded, None)),
        "disengaged | nothing selected | P - | pan +0.00 tilt +0.00 rad/s | link up | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Idle, seen(), Some(RIGHT))),
        "disengaged | confidence 0.90 | P 0.25 | pan +0.00 tilt +0.00 rad/s (would pan +0.30 tilt +0.00) | link up | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Servoing, seen(), Some(RIGHT))),
        "servoing | confidence 0.90 | P 0.25 | pan +0.30 tilt +0.00 rad/s | link up | 0 fps, age -, dropped 0",
    );
    check(
        Some(LinkState::Starting),
        nothing,
        Some(&outcome(Mode::Servoing, seen(), Some(RIGHT))),
        "servoing | confidence 0.90 | P 0.25 | pan +0.30 tilt +0.00 rad/s (not sent) | link starting | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Holding(HoldCause::Coasting), coasting, Some(CameraCommand::REST))),
        "holding: boat hidden | confidence 0.90 | P 0.25 | pan +0.00 tilt +0.00 rad/s | link up | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Holding(HoldCause::TrackLost), lost, None)),
        "holding: boat lost | lost for 2.5 s | P - | pan +0.00 tilt +0.00 rad/s | link up | 0 fps, age -, dropped 0",
    );
    check(
        Some(LinkState::Opening),
        nothing,
        Some(&outcome(Mode::Holding(HoldCause::LinkDown), seen(), Some(RIGHT))),
        "holding: link not up | confidence 0.90 | P 0.25 | pan +0.00 tilt +0.00 rad/s (not sent) (would pan +0.30 tilt +0.00) | link opening | 0 fps, age -, dropped 0",
    );
    check(
        None,
        nothing,
        Some(&outcome(Mode::Holding(HoldCause::DryRun), seen(), Some(RIGHT))),
        "holding: dry run, nothing is sent | confidence 0.90 | P 0.25 | pan +0.00 tilt +0.00 rad/s (not sent) (would pan +0.30 tilt +0.00) | dry run | 0 fps, age -, dropped 0",
    );
    check(
        up,
        nothing,
        Some(&outcome(Mode::Stopped(StopCause::ControlLost), Track::Unseeded, None)),
        "stopped: vehicle gave the control away | nothing selected | P - | pan +0.00 tilt +0.00 rad/s | link up | 0 fps, age -, dropped 0",
    );
    check(
        Some(LinkState::Opening),
        |snapshot| {
            let video = &mut snapshot.video;
            (video.fps, video.age, video.dropped) = (20.4, Some(Duration::from_millis(213)), 7);
            snapshot.vehicle.link = LinkStatus::Link(LinkState::Closing);
            snapshot.recording = RecordingState::Failed("disk full".to_owned());
        },
        Some(&outcome(Mode::Stopped(StopCause::Operator), Track::Unseeded, None)),
        "stopped: by the operator | nothing selected | P - | pan +0.00 tilt +0.00 rad/s (not sent) | link closing  ALARM: recording failed: disk full | 20 fps, age 213 ms, dropped 7",
    );
}

#[test]
fn on_a_terminal_the_line_names_the_key_that_matters() {
    let line = |mode: Mode| {
        let outcome = Some(outcome(mode, Track::Unseeded, None));
        let snapshot = Snapshot { outcome, ..Snapshot::default() };
        let mut status = StatusLine::new(Duration::ZERO).naming_keys(true);
        status.next_line(&snapshot, at(NOW_MS)).unwrap()
    };
    assert!(line(Mode::Idle).starts_with("disengaged (e engages) |"), "{}", line(Mode::Idle));
    assert!(line(Mode::Servoing).starts_with("servoing (space stops) |"));
    assert!(line(Mode::Stopped(StopCause::Operator)).starts_with("stopped: by the operator (e engages) |"));
}

#[test]
fn a_narrow_terminal_shows_the_start_of_the_line() {
    for (columns, expected) in
        [(20, "\r\u{1b}[Kdisengaged (e enga…\n"), (80, "\r\u{1b}[Kdisengaged (e engages)\n")]
    {
        let (writes, written) = channel();
        let writer = start(Forward(writes), LineStyle::Overwritten { columns: Some(columns) });
        writer.show("disengaged (e engages)".to_owned());
        drop(writer);
        assert_eq!(written.iter().collect::<String>(), expected);
    }
}

#[test]
fn a_line_is_due_once_per_interval() {
    let mut status = StatusLine::new(Duration::from_millis(200));
    let snapshot = Snapshot::default();
    let times = [1_000, 1_100, 1_199, 1_200, 1_390, 5_000];
    let is_due = times.map(|ms| status.next_line(&snapshot, at(ms)).is_some());
    assert_eq!(is_due, [true, false, false, true, false, true]);
}

/// An output that passes each write on.
struct Forward(Sender<String>);

impl Write for Forward {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = self.0.send(String::from_utf8_lossy(bytes).into_owned());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// An output whose writes last until the other end is dropped.
struct Blocked(Receiver<()>);

impl Write for Blocked {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = self.0.recv();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn start(output: impl Write + Send + 'static, style: LineStyle) -> StatusWriter {
    let (events, _) = sync_channel(1);
    StatusWriter::start(output, style, Clock::start(), FaultInjector::default(), events).unwrap()
}

#[test]
fn a_terminal_shows_one_line_that_is_overwritten() {
    for (style, expected) in
        [(LineStyle::Overwritten { columns: None }, "\r\u{1b}[Kfirst\n"), (LineStyle::Plain, "first\n")]
    {
        let (writes, written) = channel();
        let writer = start(Forward(writes), style);
        writer.show("first".to_owned());
        drop(writer);
        assert_eq!(written.iter().collect::<String>(), expected);
    }
}

#[test]
fn an_output_that_blocks_delays_nobody() {
    let (_open, gate) = channel();
    let writer = start(Blocked(gate), LineStyle::Plain);
    for line in 0..100 {
        writer.show(line.to_string());
    }
    // The end of the run does not wait for the blocked thread either.
    drop(writer);
}
