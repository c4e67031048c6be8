//! A console without sockets, threads and a run loop, for tests. The test is the session: it takes the stops
//! and the requests that reach the gateway, and publishes the snapshots.

use std::future::Future as _;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use axum::body::{Body, to_bytes};
use axum::http::{Request, Response};
use barrelman_host::clock::Clock;
use barrelman_pilot::{Input, Outcome};
use barrelman_vocab::{self as vocab, LawId, VehicleProfile, VehicleRates, VideoNumber, Videos};
use tower::ServiceExt as _;

use super::access::{Access, Role};
use super::entrance::Entrance;
use super::guard::Hosts;
use super::issued_links::IssuedLinks;
use super::library::Library;
use super::origin::{Origin, Scheme};
use super::requests::{Reply, Requester, answer, begin_request};
use super::seats::ClientId;
use super::shared::Console;
use super::tokens::{KeptTokens, Tokens, TokensInForce};
use super::{ConsoleParts, OnConsoleLost, SessionFacts, SessionTime, VideoOutlet, routes};
use crate::operator::{Answer, Gateway, SessionRequest};
use crate::snapshot::{LinkStatus, Publisher, RecordingState};
use crate::test_scenes::{at, idle};

pub(super) const CONTROL_TOKEN: &str = "control-0123456789";
pub(super) const WATCH_TOKEN: &str = "watch-0123456789ab";
/// How long the program has been running when a test begins.
const UPTIME: Duration = Duration::from_secs(3600);

/// How the console is served.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setup {
    pub(super) address: &'static str,
    pub(super) asks_for_tokens: bool,
    pub(super) on_lost: OnConsoleLost,
}

/// A live run on a machine of its own.
pub(super) const LIVE: Setup =
    Setup { address: "127.0.0.1:8480", asks_for_tokens: true, on_lost: OnConsoleLost::Stay };
/// A live run that other machines reach.
pub(super) const LIVE_OFF_LOOPBACK: Setup = Setup { address: "0.0.0.0:8480", ..LIVE };
/// A demo on loopback.
pub(super) const DEMO: Setup = Setup { asks_for_tokens: false, ..LIVE };

/// A console with the session that it serves.
pub(super) struct InMemory {
    pub(super) console: Arc<Console>,
    pub(super) publisher: Publisher,
    /// What the session answers to the requests that it takes.
    pub(super) answer: Answer,
    /// The requests that the session took.
    pub(super) taken: Vec<SessionRequest>,
}

impl InMemory {
    pub(super) fn new(setup: Setup) -> Self {
        Self::with(setup, KeptTokens::default(), None)
    }

    /// A console whose tokens are kept.
    pub(super) fn with_kept(setup: Setup, kept: KeptTokens) -> Self {
        Self::with(setup, kept, None)
    }

    /// A console with recordings.
    pub(super) fn with_library(setup: Setup, library: Library) -> Self {
        Self::with(setup, KeptTokens::default(), Some(library))
    }

    fn with(setup: Setup, kept: KeptTokens, library: Option<Library>) -> Self {
        let publisher =
            Publisher::new(&VehicleProfile::fotokite_pro(), LinkStatus::DryRun, RecordingState::Off);
        let parts = ConsoleParts {
            facts: SessionFacts {
                command: "run",
                source: "rtsp://camera/main".to_owned(),
                second_source: None,
                link: None,
                vehicle: "fotokite-pro".to_owned(),
                scenarios: Vec::new(),
            },
            gateway: Arc::new(Gateway::new(|| {})),
            snapshots: publisher.subscribe(),
            events: publisher.events(),
            videos: Videos::one(VideoOutlet::new(VideoNumber::First)),
            time: SessionTime::new(Clock::start().started_earlier(UPTIME)),
            library,
        };
        let clock = parts.time.program_clock();
        let origin = Origin { scheme: Scheme::Http, address: setup.address.parse().unwrap() };
        let tokens = Tokens { control: CONTROL_TOKEN.to_owned(), watch: WATCH_TOKEN.to_owned() };
        let entrance = Entrance {
            access: Access::new(TokensInForce::new(setup.asks_for_tokens.then_some(tokens)), origin, clock),
            links: IssuedLinks::new(origin, None, kept, None, clock.now()),
            hosts: Hosts::new(origin, vec!["boat.example".to_owned()]),
            https: None,
        };
        let console = Arc::new(Console::new(parts, None, setup.on_lost, entrance));
        Self { console, publisher, answer: Answer::ACCEPTED, taken: Vec::new() }
    }

    /// A page connects.
    pub(super) fn join(&self, name: &str, role: Role) -> ClientId {
        let now = self.console.time.clock();
        let id = self.console.with_seats(|seats| seats.join(name, role, now)).id;
        self.console.publish_seats();
        id
    }

    /// A request of a page (`client`) or of a program, and its answer.
    pub(super) fn request(
        &mut self,
        role: Role,
        client: Option<ClientId>,
        request: impl Into<vocab::Request>,
    ) -> Reply {
        let pending =
            begin_request(&self.console, Requester { role, client, stops_taken: None }, request.into());
        self.take_requests();
        let console = Arc::clone(&self.console);
        block_on(async move { answer(&console, pending).await })
    }

    /// An HTTP request, and its answer as text: the status, the headers, and the body.
    pub(super) fn call(&mut self, request: Request<Body>) -> (u16, String) {
        let router = routes::router(Arc::clone(&self.console));
        block_on(async {
            let mut call = pin!(router.oneshot(request));
            // The call gives others their turn once. Where it waits again, it waits for the session.
            let mut answered = None;
            for _ in 0..2 {
                if let Poll::Ready(ready) = call.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
                    answered = Some(ready);
                    break;
                }
            }
            let answered = match answered {
                Some(answered) => answered,
                None => {
                    self.take_requests();
                    call.await
                }
            };
            as_text(answered.unwrap()).await
        })
    }

    /// The session takes a pressed stop, and the requests that wait.
    pub(super) fn take_requests(&mut self) {
        let gateway = Arc::clone(&self.console.gateway);
        if let Some(press) = gateway.stop_latch().pending() {
            gateway.refuse_waiting();
            self.publisher.set_stops_taken(press);
            self.step(&idle(at(0)));
            gateway.stop_latch().acknowledge(press);
        }
        while let Some(submitted) = gateway.next_request() {
            self.taken.push(submitted.request);
            submitted.answer.give(self.answer.clone());
        }
    }

    /// The pilot makes a step.
    pub(super) fn step(&mut self, outcome: &Outcome) {
        self.publisher.on_step(&Input::Tick, outcome, VehicleRates::REST, LawId::Schema);
    }

    /// The texts of the event log under this key.
    pub(super) fn logged(&self, key: &str) -> Vec<String> {
        let entries = self.publisher.events().subscribe().0;
        entries.into_iter().filter(|entry| entry.key == key).map(|entry| entry.text).collect()
    }

    /// Whether the loop is told that the controlling page is gone.
    pub(super) fn is_console_lost(&self) -> bool {
        self.console.gateway.is_console_lost()
    }
}

async fn as_text(response: Response<Body>) -> (u16, String) {
    let status = response.status().as_u16();
    let mut text = String::new();
    for (name, value) in response.headers() {
        text += &format!("{name}: {}\n", value.to_str().unwrap());
    }
    let body = to_bytes(response.into_body(), usize::MAX).await.unwrap();
    text += &format!("\n{}", std::str::from_utf8(&body).unwrap());
    (status, text)
}

/// Runs a future to its end on this thread.
pub(super) fn block_on<T>(future: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
    runtime.unwrap().block_on(future)
}
