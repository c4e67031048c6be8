//! What all tasks of a console share: the session's facts, and the sending and receiving ends of what the
//! loop publishes.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::timeout;

use barrelman_experiments::scenario::ScenarioChoice;
use barrelman_pilot::Mode;
use barrelman_vocab::{LawId, Timestamp, VideoNumber, Videos};

use super::access::{Access, Pass, Role};
use super::api::{ControlSeat, Hello, StatusSnapshot};
use super::entrance::Entrance;
use super::guard::Hosts;
use super::https::Identity;
use super::issued_links::IssuedLinks;
use super::left_moving::LeftMoving;
use super::library::Library;
use super::map::Map;
use super::on_lost::OnConsoleLost;
use super::pictures::PictureSlot;
use super::seats::{ClientId, Seats};
use super::session_time::SessionTime;
use super::status::status_of;
use super::video_relay::VideoRelay;
use crate::operator::{Gateway, is_under_way};
use crate::snapshot::{EventLog, Level, SharedSnapshot, Snapshot};

/// Rate of a nudge that the page shows, rad/s.
const NUDGE_RATE: f64 = barrelman_pilot::NUDGE_RATE_RAD_PER_S;

/// How long the end of a connection waits for a page that takes nothing.
pub(super) const FAREWELL: Duration = Duration::from_millis(300);

/// How long a page may be gone, for example while its device sleeps, and keep its cookie when the tokens are
/// renewed by age.
const ABSENCE: Duration = Duration::from_secs(600);
/// After a renewal by age that had to wait for a motion, the next look.
const RENEWAL_PAUSE: Duration = Duration::from_secs(10);

/// What does not change in a session, for the page.
#[derive(Debug, Clone)]
pub struct SessionFacts {
    /// `run` or `demo`.
    pub command: &'static str,
    /// Where the video comes from, without passwords.
    pub source: String,
    /// Where the second video comes from; `None`: there is one video.
    pub second_source: Option<String>,
    /// Where commands go, without passwords; `None`: a dry run.
    pub link: Option<String>,
    /// Name of the vehicle profile.
    pub vehicle: String,
    /// The scenarios that a new drive can have; empty: the world is not simulated.
    pub scenarios: Vec<ScenarioChoice>,
}

/// What the pages get of one video.
#[derive(Debug, Clone)]
pub struct VideoOutlet {
    /// Encoded units, where browsers can decode them.
    pub relay: Arc<VideoRelay>,
    /// Pictures, encoded anew as JPEG.
    pub pictures: Arc<PictureSlot>,
}

impl VideoOutlet {
    /// Nothing so far of this video.
    pub fn new(number: VideoNumber) -> Self {
        let (relay, pictures) = (VideoRelay::new(number), PictureSlot::new(number));
        Self { relay: Arc::new(relay), pictures: Arc::new(pictures) }
    }
}

/// What the pages have shown.
#[derive(Default)]
struct Passes {
    connected: BTreeMap<ClientId, Pass>,
    /// Those of pages that went less than [`ABSENCE`] ago, each with the time when it was last connected.
    absent: Vec<(Pass, Timestamp)>,
}

/// What a console is made of.
pub struct ConsoleParts {
    /// The session.
    pub facts: SessionFacts,
    /// Where requests go.
    pub gateway: Arc<Gateway>,
    /// The newest snapshot.
    pub snapshots: watch::Receiver<SharedSnapshot>,
    /// The event log.
    pub events: Arc<EventLog>,
    /// The video or videos.
    pub videos: Videos<VideoOutlet>,
    /// The time of the session.
    pub time: SessionTime,
    /// The recordings; `None`: the program has no folder of them.
    pub library: Option<Library>,
}

/// What all tasks of a console share.
pub(super) struct Console {
    pub(super) facts: SessionFacts,
    on_lost: OnConsoleLost,
    pub(super) access: Access,
    pub(super) links: IssuedLinks,
    pub(super) hosts: Hosts,
    /// The certificate; `None`: the console is not encrypted.
    pub(super) https: Option<Arc<Identity>>,
    pub(super) gateway: Arc<Gateway>,
    pub(super) snapshots: watch::Receiver<SharedSnapshot>,
    pub(super) events: Arc<EventLog>,
    pub(super) videos: Videos<VideoOutlet>,
    pub(super) time: SessionTime,
    pub(super) library: Option<Arc<Library>>,
    pub(super) map: Option<Arc<Map>>,
    pub(super) seats: Mutex<Seats>,
    passes: Mutex<Passes>,
    pub(super) seat_changes: watch::Sender<ControlSeat>,
    /// Whether the loop was woken because no page watches over the boat any more.
    is_vessel_left: AtomicBool,
    /// Whether the program ends.
    pub(super) ending: watch::Sender<Option<LeftMoving>>,
}

impl Console {
    pub(super) fn new(
        parts: ConsoleParts,
        map: Option<Map>,
        on_lost: OnConsoleLost,
        entrance: Entrance,
    ) -> Self {
        Self {
            map: map.map(Arc::new),
            on_lost,
            access: entrance.access,
            links: entrance.links,
            hosts: entrance.hosts,
            https: entrance.https,
            facts: parts.facts,
            gateway: parts.gateway,
            snapshots: parts.snapshots,
            events: parts.events,
            videos: parts.videos,
            time: parts.time,
            library: parts.library.map(Arc::new),
            seats: Mutex::default(),
            passes: Mutex::default(),
            seat_changes: watch::Sender::new(ControlSeat::default()),
            is_vessel_left: AtomicBool::new(true),
            ending: watch::Sender::new(None),
        }
    }

    /// The video that the pilot sees.
    pub(super) fn tracked_video(&self) -> &VideoOutlet {
        let number = self.snapshots.borrow().video.number;
        self.videos.get(number).unwrap_or(&self.videos.first)
    }

    /// The newest state, in the API's form.
    pub(super) fn status(&self) -> StatusSnapshot {
        self.status_of(&self.snapshots.borrow())
    }

    /// A state in the API's form.
    pub(super) fn status_of(&self, snapshot: &Snapshot) -> StatusSnapshot {
        status_of(snapshot, &self.videos.as_ref().map(|_, outlet| outlet.relay.codec()))
    }

    /// Uses the seats. Does not wait: nobody holds them across a wait.
    pub(super) fn with_seats<T>(&self, f: impl FnOnce(&mut Seats) -> T) -> T {
        f(&mut self.seats.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Tells all pages who controls, and the loop whether a page does.
    pub(super) fn publish_seats(&self) {
        let state = self.with_seats(|seats| seats.state());
        if state.holder.is_some() {
            self.gateway.set_console_lost(false);
        }
        self.seat_changes.send_replace(state);
    }

    /// A page connects.
    pub(super) fn join(&self, name: &str, pass: Pass) -> ClientId {
        let id = self.with_seats(|seats| seats.join(name, pass.role, self.time.clock())).id;
        self.with_passes(|passes| passes.connected.insert(id, pass));
        self.publish_seats();
        id
    }

    /// A page is gone.
    pub(super) fn leave(&self, id: ClientId) {
        let now = self.time.clock();
        self.with_seats(|seats| seats.leave(id, now));
        self.with_passes(|Passes { connected, absent }| {
            if let Some(pass) = connected.remove(&id) {
                absent.retain(|(other, left)| *other != pass && now.since(*left) < ABSENCE);
                absent.push((pass, now));
            }
        });
        self.publish_seats();
    }

    /// What a page that is connected has shown.
    pub(super) fn pass_of_page(&self, id: ClientId) -> Option<Pass> {
        self.with_passes(|passes| passes.connected.get(&id).cloned())
    }

    /// What the pages have shown that are connected, or went less than [`ABSENCE`] ago.
    pub(super) fn passes_of_pages(&self, now: Timestamp) -> Vec<Pass> {
        self.with_passes(|Passes { connected, absent }| {
            let absent = absent.iter().filter(|(_, left)| now.since(*left) < ABSENCE);
            connected.values().chain(absent.map(|(pass, _)| pass)).cloned().collect()
        })
    }

    /// Whether the camera follows, searches, or makes test motions.
    pub(super) fn may_follow(&self) -> bool {
        match self.snapshots.borrow().outcome.as_ref().map(|outcome| outcome.mode) {
            Some(Mode::Servoing | Mode::Holding(_) | Mode::Searching | Mode::Calibrating) => true,
            Some(Mode::Idle | Mode::Nudging | Mode::Stopped(_)) | None => false,
        }
    }

    /// When the tokens are renewed by age; `None`: never. Not while camera or boat move by this program's
    /// command: who watches over them may come back with a cookie.
    pub(super) fn token_renewal(&self, now: Timestamp) -> Option<Timestamp> {
        let due = self.links.due()?;
        let is_boat_under_way =
            self.snapshots.borrow().outcome.as_ref().is_some_and(|outcome| is_under_way(outcome.vessel.mode));
        let is_moving = self.may_follow() || is_boat_under_way;
        Some(if is_moving { due.max(now.plus(RENEWAL_PAUSE)) } else { due })
    }

    /// Disconnects the pages whose passes do not hold any more: each page looks at its own.
    pub(super) fn sign_out(&self) {
        self.publish_seats();
    }

    fn with_passes<T>(&self, f: impl FnOnce(&mut Passes) -> T) -> T {
        f(&mut self.passes.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Tells all pages that the program ends, and what may still move. Waits until they are disconnected: a
    /// page that hears nothing more would take the end for a lost connection.
    pub(super) async fn end(&self, left: LeftMoving) {
        let mut seats = self.seat_changes.subscribe();
        self.ending.send_replace(Some(left));
        let _ = timeout(FAREWELL, seats.wait_for(has_no_page)).await;
    }

    /// A program without a socket made a request: one that may control is still there.
    pub(super) fn hear_program(&self, role: Role) {
        if role == Role::Control {
            self.with_seats(|seats| seats.hear_program(self.time.clock()));
        }
    }

    /// Tells the loop until when a page watches over the boat.
    pub(super) fn watch_vessel(&self) {
        let until = self.with_seats(|seats| seats.vessel_watched_until());
        self.gateway.watch_vessel_until(until);
        let is_left = until.is_none_or(|until| until < self.time.clock());
        if self.is_vessel_left.swap(is_left, Ordering::Relaxed) != is_left {
            self.gateway.wake();
        }
    }

    /// Frees the seat of a page that was lost for too long, and does what the session says for that case.
    pub(super) fn expire_seats(&self) {
        self.watch_vessel();
        let who = if self.with_seats(|seats| seats.program_controls()) {
            "the program in control is silent"
        } else {
            "the controlling page is gone"
        };
        if !self.with_seats(|seats| seats.expire(self.time.clock())) {
            // A program that asked may be gone.
            if *self.seat_changes.borrow() != self.with_seats(|seats| seats.state()) {
                self.publish_seats();
            }
            return;
        }
        let now = self.time.now();
        let is_engaged = self.status().mode.engaged;
        if self.on_lost == OnConsoleLost::Stop {
            self.events.add(now, Level::Alarm, "console-lost", format!("{who}: stopped"));
            self.gateway.stop();
        } else {
            let text = if is_engaged { "; the camera stays engaged" } else { "" };
            let text = format!("{who}{text}");
            self.events.add(now, Level::Warning, "console-lost", text);
        }
        self.gateway.set_console_lost(true);
        self.publish_seats();
    }

    /// The first message to a page.
    pub(super) fn hello(&self, client: ClientId, role: Role) -> Hello {
        Hello {
            client,
            may_control: role == Role::Control,
            version: env!("CARGO_PKG_VERSION"),
            command: self.facts.command,
            source: self.facts.source.clone(),
            second_source: self.facts.second_source.clone(),
            link: self.facts.link.clone(),
            vehicle: self.facts.vehicle.clone(),
            scenarios: self.facts.scenarios.clone(),
            laws: vec![LawId::MinimumEnergy, LawId::TimeFuel, LawId::Eco, LawId::Intermittent, LawId::Schema],
            nudge_rate: NUDGE_RATE,
            map: self.map.as_ref().map(|map| map.about().clone()),
            on_console_lost: if self.on_lost == OnConsoleLost::Stop { "stop" } else { "stay" },
        }
    }
}

/// Whether no page is connected.
fn has_no_page(seats: &ControlSeat) -> bool {
    seats.clients.iter().all(|client| Some(*client) == seats.program)
}
