//! The link thread with a vehicle that takes requests and answers them, as over HTTP: the same worker as for
//! bytes.
//!
//! A command of this vehicle names its duration and expires by itself. The vehicle answers with a status.

use std::cell::{Cell, RefCell};

use barrelman_vocab::telemetry::ControlState;
use barrelman_vocab::{AngularRate, VehicleRates};

use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp};
use barrelman_wire::{LinkHistory, NextAction};

use super::*;
use crate::dead_mans_switch::RequestedRates;
use crate::port::PortError;

const RENEWAL: Duration = Duration::from_millis(200);
const ANSWER_TIMEOUT: Duration = Duration::from_secs(1);
const FORBIDDEN: u16 = 403;
const TURNING: VehicleRates =
    VehicleRates::turning(AngularRate::from_radians_per_second(0.2), AngularRate::ZERO);

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// Turn with these rates for this time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    rates: VehicleRates,
    duration: Duration,
}

/// The answer to a request.
#[derive(Debug, Clone, Copy)]
struct Answer {
    status: u16,
}

/// One request at a time; the next one after the answer.
struct RequestSession {
    wanted: (VehicleRates, Option<Timestamp>),
    sent: Option<(VehicleRates, Timestamp)>,
    waits_since: Option<Timestamp>,
    has_answered: bool,
    is_closing: bool,
}

impl Session for RequestSession {
    type Sent = Turn;
    type Received = Answer;
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Turn>) -> NextAction {
        if let Some(since) = self.waits_since {
            return if now.since(since) >= ANSWER_TIMEOUT {
                NextAction::Reopen { reason: "no answer" }
            } else {
                NextAction::WaitUntil(since.plus(ANSWER_TIMEOUT))
            };
        }
        let (rates, renew_by) = if self.is_closing { (VehicleRates::REST, None) } else { self.wanted };
        let is_due = self.sent.is_none_or(|(last, when)| last != rates || now.since(when) >= RENEWAL);
        if self.is_closing && self.sent.is_some_and(|(last, _)| last.is_rest()) {
            return NextAction::Closed;
        }
        if is_due {
            let duration = renew_by.map_or(Duration::ZERO, |until| until.since(now));
            out.push(Turn { rates, duration });
            (self.sent, self.waits_since) = (Some((rates, now)), Some(now));
        }
        NextAction::WaitUntil(now.plus(RENEWAL))
    }

    fn received(&mut self, answer: &Answer, now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        (self.waits_since, self.has_answered) = (None, true);
        let control = if answer.status == FORBIDDEN { ControlState::Elsewhere } else { ControlState::Ours };
        let ground = Report::Ground { control, uptime_s: 0.0, battery_v: 0.0, tether_m: 0.0 };
        report(Telemetry { at: now, report: ground });
    }

    fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.wanted = (rates, renew_by);
    }

    fn close(&mut self, _now: Timestamp) {
        self.is_closing = true;
    }

    fn may_be_turning(&self) -> bool {
        false
    }

    fn link_state(&self) -> LinkState {
        match (self.is_closing, self.has_answered) {
            (true, _) => LinkState::Closing,
            (false, true) => LinkState::Up,
            (false, false) => LinkState::Starting,
        }
    }

    fn last_will(&self, _: Timestamp) -> Vec<WillStep<Turn>> {
        let packet = Turn { rates: VehicleRates::REST, duration: Duration::ZERO };
        vec![WillStep { packet, pause: Duration::ZERO }]
    }
}

/// A vehicle that answers 5 ms after each request, with a clock of 1 ms.
struct Vehicle {
    mailbox: Arc<Mailbox>,
    now: Cell<Timestamp>,
    status: u16,
    answers_at: Cell<Option<Timestamp>>,
    turns: RefCell<Vec<(Timestamp, Turn)>>,
}

impl PortIo for &Vehicle {
    type Port = ();
    type Sent = Turn;
    type Received = Answer;

    fn now(&self) -> Timestamp {
        self.now.get()
    }

    fn open(&self) -> Result<(), PortError> {
        Ok(())
    }

    fn send(&self, (): &mut (), turn: &Turn) -> io::Result<()> {
        self.turns.borrow_mut().push((self.now(), *turn));
        self.answers_at.set(Some(self.now().plus(Duration::from_millis(5))));
        Ok(())
    }

    fn receive(&self, (): &mut (), each: &mut dyn FnMut(&Answer)) -> io::Result<()> {
        if self.answers_at.take().is_some() {
            each(&Answer { status: self.status });
        }
        Ok(())
    }

    fn wait(&self, _port: Option<&()>, wait: Duration) -> bool {
        let until = self.now().plus(wait);
        let has_answer = || self.answers_at.get().is_some_and(|due| due <= self.now());
        while self.now() < until && !has_answer() {
            self.sleep(Duration::from_millis(1));
        }
        has_answer()
    }

    fn sleep(&self, pause: Duration) {
        self.now.set(self.now().plus(pause));
        let rates = if self.now() < at(1_000) { VehicleRates::REST } else { TURNING };
        self.mailbox.request(RequestedRates { command: rates, renew_by: Some(at(1_500)) });
        if self.now() >= at(2_000) {
            self.mailbox.close();
        }
    }
}

/// Runs the link thread for two seconds: rest, then from 1 s on rates that are to be renewed by 1.5 s.
fn serve(status: u16, faults: &str) -> (bool, Vec<(Timestamp, Turn)>, Vec<LinkReport>) {
    let mailbox = Arc::new(Mailbox::new().unwrap());
    let (now, answers_at, turns) = (Cell::new(at(0)), Cell::default(), RefCell::default());
    let vehicle = Vehicle { mailbox: Arc::clone(&mailbox), now, status, answers_at, turns };
    let reports = RefCell::new(Vec::new());
    let open = |_| {
        let wanted = (VehicleRates::REST, None);
        let closed =
            RequestSession { wanted, sent: None, waits_since: None, has_answered: false, is_closing: false };
        Box::new(closed)
    };
    let worker: Worker<RequestSession, _, _> = Worker {
        persistence: Duration::ZERO,
        mailbox: Arc::clone(&mailbox),
        io: &vehicle,
        history: LinkHistory::default(),
        open_session: Arc::new(open),
        report: |report| {
            reports.borrow_mut().push(report);
            true
        },
    };
    worker.run(Some(()), FaultPlan::parse(faults).unwrap());
    (mailbox.is_stop_sent(), vehicle.turns.take(), reports.take())
}

#[test]
fn a_vehicle_that_answers_requests_is_moved_and_rested_by_the_same_worker() {
    let (is_stop_sent, turns, _) = serve(200, "");
    let moving: Vec<_> = turns.iter().filter(|(_, turn)| !turn.rates.is_rest()).collect();
    assert!(is_stop_sent && moving.len() >= 2, "{turns:?}");
    for (time, turn) in &moving {
        assert_eq!(time.plus(turn.duration), at(1_500), "a command ends when its renewal is due");
    }
    let rests = turns.iter().find(|(time, turn)| *time > at(1_100) && turn.rates.is_rest());
    assert_eq!(rests.unwrap().0, at(1_550), "the dead-man's switch");
    assert!(turns.last().unwrap().1.rates.is_rest());
}

#[test]
fn a_refusal_is_reported_as_control_that_is_not_ours() {
    let (_, _, reports) = serve(FORBIDDEN, "");
    let is_refusal = |report: &LinkReport| {
        matches!(report, LinkReport::Telemetry(Telemetry { report: Report::Ground { control, .. }, .. })
            if *control == ControlState::Elsewhere)
    };
    assert!(reports.iter().any(is_refusal));
}

#[test]
fn a_vehicle_that_does_not_answer_is_tried_again() {
    let (_, turns, reports) = serve(200, "stall@0+0.9");
    assert!(
        reports.contains(&LinkReport::Lost { reason: "no answer".to_owned(), may_be_turning: false }),
        "{reports:?}"
    );
    assert!(turns.iter().any(|(_, turn)| !turn.rates.is_rest()), "{turns:?}");
}
