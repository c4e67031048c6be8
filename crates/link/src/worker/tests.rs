//! The link thread in front of a simulated ground station, with a simulated clock: no test waits.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

use barrelman_vocab::{AngularRate, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::ground_station::{GroundStation, GroundStationSettings};
use barrelman_wire::fotokite_pro::session::STOP_DELAY;
use barrelman_wire::{ByteProtocol, ByteProtocolName, ByteSession, Framing, LinkHistory, OpenSession as _};

use barrelman_wire::fotokite_pro::ground_station::SensorReadings;

use super::*;
use crate::dead_mans_switch::RequestedRates;
use crate::port::PortError;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Telemetry, Timestamp};

/// The session is up well before this time, ms.
const UP_MS: u64 = 4_000;
const MOVING: VehicleRates = VehicleRates::turning(
    AngularRate::from_radians_per_second(0.2),
    AngularRate::from_radians_per_second(-0.1),
);

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// What happens at a time of the test.
#[derive(Debug, Clone, Copy)]
enum Action {
    /// The run loop requests rates, to be renewed by this time, ms.
    Request(VehicleRates, u64),
    /// The run loop closes the link.
    Close,
    /// The port fails, and cannot be opened.
    Unplug,
    /// The port fails when `stop` is sent; from the beginning on.
    UnplugAtStop,
    /// The port can be opened again.
    Plug,
    /// The ground station no longer answers.
    Silence,
    /// The ground station answers again.
    Answers,
}

use Action::{Answers, Close, Plug, Request, Silence, Unplug, UnplugAtStop};

/// A ground station behind a port, with the clock and the script of the test.
struct Bench {
    mailbox: Arc<Mailbox>,
    now: Cell<Timestamp>,
    script: RefCell<VecDeque<(u64, Action)>>,
    station: RefCell<GroundStation>,
    is_silent: Cell<bool>,
    is_plugged: Cell<bool>,
    /// Whether the port fails when `stop` is sent, once.
    fails_at_stop: Cell<bool>,
    /// Bytes on the way to the link thread.
    incoming: RefCell<Vec<u8>>,
    /// The lines that the ground station received, with their times.
    lines: RefCell<Vec<(Timestamp, String)>>,
    /// The rates in force at the ground station whenever they changed.
    rates: RefCell<Vec<(Timestamp, VehicleRates)>>,
}

/// A port of the bench. It fails for good once it was unplugged.
struct BenchPort;

impl Bench {
    /// Lets one millisecond pass. Returns whether the mailbox was changed.
    fn advance(&self) -> bool {
        self.now.set(self.now.get().plus(Duration::from_millis(1)));
        let now = self.now.get();
        let mut is_woken = false;
        while let Some((_, action)) = self.script.borrow_mut().pop_front_if(|(ms, _)| at(*ms) <= now) {
            match action {
                Request(rates, renew_by) => {
                    self.mailbox.request(RequestedRates { command: rates, renew_by: Some(at(renew_by)) });
                    is_woken = true;
                }
                Close => {
                    self.mailbox.close();
                    is_woken = true;
                }
                Unplug => self.is_plugged.set(false),
                UnplugAtStop => {}
                Plug => self.is_plugged.set(true),
                Silence => self.is_silent.set(true),
                Answers => self.is_silent.set(false),
            }
        }
        if !self.is_silent.get() {
            let mut station = self.station.borrow_mut();
            station.tick(now);
            station.write_telemetry(&SensorReadings::LEVEL, now, &mut self.incoming.borrow_mut());
        }
        is_woken
    }

    fn gone() -> io::Error {
        io::Error::new(io::ErrorKind::BrokenPipe, "unplugged")
    }
}

impl PortIo for &Bench {
    type Port = BenchPort;
    type Sent = Vec<u8>;
    type Received = [u8];

    fn now(&self) -> Timestamp {
        self.now.get()
    }

    fn open(&self) -> Result<BenchPort, PortError> {
        let unreachable = || PortError::Unreachable { address: "bench".to_owned(), source: Bench::gone() };
        self.is_plugged.get().then_some(BenchPort).ok_or_else(unreachable)
    }

    fn send(&self, _: &mut BenchPort, bytes: &Vec<u8>) -> io::Result<()> {
        if bytes.starts_with(b"stop") && self.fails_at_stop.take() {
            return Err(Bench::gone());
        }
        if !self.is_plugged.get() {
            return Err(Bench::gone());
        }
        let now = self.now.get();
        let mut answer = Vec::new();
        let mut station = self.station.borrow_mut();
        let log = |line: &str| self.lines.borrow_mut().push((now, line.to_owned()));
        station.receive(bytes, now, &mut answer, log);
        if !self.is_silent.get() {
            self.incoming.borrow_mut().extend(answer);
        }
        let rates = VehicleRates::turning(station.rates().yaw, station.rates().pitch);
        let mut changes = self.rates.borrow_mut();
        if changes.last().map_or(VehicleRates::REST, |(_, last)| *last) != rates {
            changes.push((now, rates));
        }
        Ok(())
    }

    fn receive(&self, _: &mut BenchPort, each: &mut dyn FnMut(&[u8])) -> io::Result<()> {
        if !self.is_plugged.get() {
            return Err(Bench::gone());
        }
        each(&self.incoming.take());
        Ok(())
    }

    fn wait(&self, port: Option<&BenchPort>, wait: Duration) -> bool {
        let until = self.now.get().plus(wait);
        let is_readable = || port.is_some() && (!self.incoming.borrow().is_empty() || !self.is_plugged.get());
        while self.now.get() < until && !is_readable() {
            if self.advance() {
                break;
            }
        }
        is_readable()
    }

    fn sleep(&self, pause: Duration) {
        let until = self.now.get().plus(pause);
        while self.now.get() < until {
            self.advance();
        }
    }
}

/// What a link thread did.
struct Served {
    is_stop_sent: bool,
    lines: Vec<(Timestamp, String)>,
    rates: Vec<(Timestamp, VehicleRates)>,
    /// The reports, without the vehicle's telemetry.
    reports: Vec<String>,
    /// The last line before each report of a stop.
    stops: Vec<Option<String>>,
}

impl Served {
    /// The names of the last lines: `Yaw`, `Gimbal`, `stop`.
    fn last_lines(&self, count: usize) -> Vec<&str> {
        let lines = &self.lines[self.lines.len() - count..];
        lines.iter().map(|(_, line)| line.split(' ').next().unwrap()).collect()
    }

    #[track_caller]
    fn check_ends_with_zeros_and_stop(&self) {
        assert!(self.is_stop_sent);
        assert_eq!(self.rates.last().map(|(_, rates)| *rates), Some(VehicleRates::REST), "{:?}", self.rates);
        let [.., (zeros_at, zeros), (stop_at, stop)] = &self.lines[..] else { panic!("{:?}", self.lines) };
        assert!(zeros.ends_with(" 0.000000"), "{zeros}");
        assert_eq!(stop, "stop");
        assert!(stop_at.since(*zeros_at) >= STOP_DELAY);
    }
}

/// The worker of a link to a Fotokite Pro.
pub(super) fn fotokite_worker<I, R>(
    mailbox: Arc<Mailbox<VehicleRates>>,
    io: I,
    report: R,
) -> Worker<ByteSession<VehicleRates>, I, R> {
    let protocol = ByteProtocol {
        protocol: ByteProtocolName::of(VehicleProfile::fotokite_pro().protocol).unwrap(),
        framing: Framing::LineFeed,
        baud: 115_200,
    };
    Worker {
        persistence: Duration::ZERO,
        history: LinkHistory::default(),
        open_session: Arc::new(move |now| protocol.open(now)),
        mailbox,
        io,
        report,
    }
}

/// Runs the link thread through a script of times in milliseconds and actions.
fn serve(faults: &str, script: &[(u64, Action)]) -> Served {
    serve_with_room(faults, script, None)
}

/// The same with a loop that has no room for reports before a time.
fn serve_with_room(faults: &str, script: &[(u64, Action)], room_from_ms: Option<u64>) -> Served {
    let mailbox = Arc::new(Mailbox::new().unwrap());
    let bench = Bench {
        mailbox: Arc::clone(&mailbox),
        now: Cell::new(at(0)),
        script: RefCell::new(script.iter().copied().collect()),
        station: RefCell::new(GroundStation::boot(GroundStationSettings::default(), at(0))),
        is_silent: Cell::new(false),
        is_plugged: Cell::new(true),
        fails_at_stop: Cell::new(script.iter().any(|(_, action)| matches!(action, UnplugAtStop))),
        incoming: RefCell::default(),
        lines: RefCell::default(),
        rates: RefCell::default(),
    };
    let (bench, reports) = (&bench, RefCell::new(Vec::new()));
    let stops = &RefCell::new(Vec::new());
    let reported = &reports;
    let report = move |report| {
        let text = match report {
            LinkReport::Telemetry(Telemetry { report: Report::Link(state), .. }) => format!("{state:?}"),
            LinkReport::Telemetry(_) => return true,
            LinkReport::Lost { reason, .. } => format!("lost: {reason}"),
            LinkReport::Stopped(_) => {
                stops.borrow_mut().push(bench.lines.borrow().last().map(|(_, line)| line.clone()));
                return true;
            }
            LinkReport::Control { .. } | LinkReport::HeldUp => return true,
            LinkReport::Suspended(_) | LinkReport::GuardLost(_) | LinkReport::NotReached(_) => {
                panic!("not here")
            }
            LinkReport::Panicked => "panicked".to_owned(),
        };
        let mut reported = reported.borrow_mut();
        let is_taken = room_from_ms.is_none_or(|ms| bench.now.get() >= at(ms));
        if is_taken {
            reported.push(text);
        }
        is_taken
    };
    let worker = fotokite_worker(Arc::clone(&mailbox), bench, report);
    worker.run(Some(BenchPort), FaultPlan::parse(faults).unwrap());
    Served {
        is_stop_sent: mailbox.is_stop_sent(),
        lines: bench.lines.take(),
        rates: bench.rates.take(),
        reports: reports.take(),
        stops: stops.take(),
    }
}

#[test]
fn requested_rates_are_written() {
    let served = serve("", &[(UP_MS, Request(MOVING, 9_000)), (5_000, Close)]);
    let moving = served.rates.iter().find(|(_, rates)| *rates == MOVING).unwrap();
    assert!(moving.0.since(at(UP_MS)) <= Duration::from_millis(50), "{:?}", served.rates);
    assert_eq!(served.reports, ["Starting", "Up", "Closing", "Closed"]);
}

#[test]
fn rates_that_are_not_renewed_rest_the_camera() {
    let served = serve("", &[(UP_MS, Request(MOVING, 5_000)), (7_000, Close)]);
    let (rest_at, rates) = *served.rates.last().unwrap();
    assert_eq!(rates, VehicleRates::REST);
    assert!(rest_at >= at(5_050) && rest_at <= at(5_060), "{:?}", served.rates);
}

#[test]
fn renewed_rates_go_on_after_an_expiry() {
    let served =
        serve("", &[(UP_MS, Request(MOVING, 4_500)), (6_000, Request(MOVING, 9_000)), (7_000, Close)]);
    assert!(served.rates.iter().any(|(time, rates)| *time >= at(6_000) && *rates == MOVING));
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn closing_writes_zeros_at_once_and_stop_half_a_second_later() {
    let served = serve("", &[(UP_MS, Request(MOVING, 9_000)), (5_000, Close)]);
    assert_eq!(served.rates.last(), Some(&(at(5_000), VehicleRates::REST)), "{:?}", served.rates);
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn closing_before_the_session_is_up_stops_the_vehicle() {
    let served = serve("", &[(100, Close)]);
    assert!(served.is_stop_sent);
    assert_eq!(served.last_lines(3), ["Gimbal", "Yaw", "stop"]);
}

#[test]
fn a_lost_port_is_reopened_and_rates_are_written_again() {
    let script = [(UP_MS, Request(MOVING, 60_000)), (5_000, Unplug), (6_000, Plug), (12_000, Close)];
    let served = serve("", &script);
    assert_eq!(
        served.reports,
        ["Starting", "Up", "lost: unplugged", "Opening", "Starting", "Up", "Closing", "Closed"]
    );
    assert!(served.rates.iter().any(|(time, rates)| *time > at(6_000) && *rates == MOVING));
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn a_ground_station_that_falls_silent_is_reported_once() {
    let served = serve("", &[(UP_MS, Silence), (20_000, Unplug), (20_001, Close)]);
    let silences = served.reports.iter().filter(|report| report.ends_with("does not answer")).count();
    assert_eq!(silences, 1, "{:?}", served.reports);
    assert!(!served.is_stop_sent, "nothing can be sent on a port that is lost");
}

#[test]
fn every_silence_is_reported() {
    let script = [(UP_MS, Silence), (20_000, Answers), (40_000, Silence), (60_000, Answers), (80_000, Close)];
    let served = serve("", &script);
    let silences = served.reports.iter().filter(|report| report.ends_with("does not answer")).count();
    assert_eq!(silences, 2, "{:?}", served.reports);
}

#[test]
fn closing_a_lost_link_tries_the_port_once_more() {
    let script = [(UP_MS, Request(MOVING, 60_000)), (5_000, Unplug), (5_600, Plug), (5_600, Close)];
    let served = serve("", &script);
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn a_stop_is_told_once_it_was_sent() {
    let served = serve("", &[(0, UnplugAtStop), (UP_MS, Request(MOVING, 9_000)), (5_000, Close)]);
    served.check_ends_with_zeros_and_stop();
    assert!(served.reports.iter().any(|report| report.starts_with("lost")), "{:?}", served.reports);
    assert_eq!(served.stops, [Some("stop".to_owned())]);
}

#[test]
fn a_panic_sends_the_emergency_stop() {
    let served = serve("panic@5", &[(UP_MS, Request(MOVING, 60_000))]);
    assert_eq!(served.reports, ["Starting", "Up", "panicked"]);
    let zeros = ["Gimbal", "Yaw"];
    assert_eq!(served.last_lines(7), [&zeros[..], &zeros, &zeros, &["stop"]].concat());
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn a_change_of_the_link_that_found_no_room_is_reported_when_there_is_some() {
    let script = [(5_000, Unplug), (6_000, Plug), (12_000, Close)];
    let served = serve_with_room("", &script, Some(9_000));
    assert_eq!(served.reports, ["Up", "Closing", "Closed"]);
}

#[test]
fn a_panic_is_reported_as_soon_as_there_is_room() {
    let served = serve_with_room("panic@5", &[(UP_MS, Request(MOVING, 60_000))], Some(8_000));
    assert_eq!(served.reports, ["panicked"]);
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn a_panic_does_not_wait_for_a_loop_that_closes_the_link() {
    let script = [(UP_MS, Request(MOVING, 60_000)), (8_000, Close)];
    let served = serve_with_room("panic@5", &script, Some(u64::MAX / 1_000_000));
    assert!(served.reports.is_empty());
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn a_stalled_line_carries_nothing_in_either_direction_and_gives_no_error() {
    let script = [(UP_MS, Request(MOVING, 5_000)), (20_000, Close)];
    let served = serve("stall@4.5+2", &script);
    let during = |time: &Timestamp| *time >= at(4_500) && *time < at(6_500);
    assert!(!served.lines.iter().any(|(time, _)| during(time)), "{:?}", served.lines);
    let (rest_at, rates) = *served.rates.last().unwrap();
    assert_eq!(rates, VehicleRates::REST, "{:?}", served.rates);
    assert!(rest_at >= at(6_500) && rest_at <= at(7_100), "the camera turned until then: {rest_at}");
    assert_eq!(served.reports, ["Starting", "Up", "Closing", "Closed"]);
}

#[test]
fn a_line_that_stalls_for_long_ends_the_session() {
    let served = serve("stall@4.5+6", &[(20_000, Close)]);
    let lost = "lost: the ground station does not answer";
    assert_eq!(served.reports[..5], ["Starting", "Up", "Silent", lost, "Opening"]);
    assert_eq!(served.reports[7..], ["Starting", "Up", "Closing", "Closed"], "the second attempt is heard");
}

#[test]
fn a_port_that_is_disconnected_on_purpose_is_lost_and_opened_again() {
    let script = [(UP_MS, Request(MOVING, 60_000)), (12_000, Close)];
    let served = serve("disconnect@5+1", &script);
    let lost = "lost: disconnected on purpose";
    assert_eq!(served.reports, ["Starting", "Up", lost, "Opening", "Starting", "Up", "Closing", "Closed"]);
    let during = |time: &Timestamp| *time >= at(5_000) && *time < at(6_000);
    assert!(!served.lines.iter().any(|(time, _)| during(time)), "{:?}", served.lines);
    assert!(served.rates.iter().any(|(time, rates)| *time > at(6_000) && *rates == MOVING));
    served.check_ends_with_zeros_and_stop();
}

#[test]
fn dropped_packets_are_not_sent_while_the_vehicle_is_heard() {
    let script = [(UP_MS, Request(MOVING, 5_000)), (9_000, Close)];
    let served = serve("drop@4.5+2", &script);
    let during = |time: &Timestamp| *time >= at(4_500) && *time < at(6_500);
    assert!(!served.lines.iter().any(|(time, _)| during(time)), "{:?}", served.lines);
    assert_eq!(served.reports, ["Starting", "Up", "Closing", "Closed"]);
    served.check_ends_with_zeros_and_stop();
}
