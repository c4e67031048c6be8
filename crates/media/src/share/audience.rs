//! The connections of a share, and who of them reads.
//!
//! The state has one lock. The door and the threads of the clients change it, the main thread feeds it.

use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::Channel;
use barrelman_media_protocol::share::{Demand, FromShare, MAX_READERS};
use gstreamer as gst;
use gstreamer_app::AppSrc;
use gstreamer_rtsp_server::RTSPClient;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::reader::Reader;

/// Largest number of connections, with those that do not read.
pub(super) const MAX_CONNECTIONS: usize = 24;

/// How long a connection may do nothing before it reads.
const MAX_IDLE: Duration = Duration::from_secs(10);

/// How long a reader may rest before it plays, or while it is paused.
const MAX_REST: Duration = Duration::from_secs(60);

/// Most bytes that wait in front of a reader's packets: then it counts as one whose socket is full.
const MAX_WAITING: u64 = 1 << 20;

/// A connection.
struct Connection {
    client: RTSPClient,
    /// The same socket as the client's.
    socket: TcpStream,
    /// Since when it does not play.
    rests_since: Option<Instant>,
    /// What it reads; `None`: nothing yet.
    feed: Option<Feed>,
}

struct Feed {
    source: AppSrc,
    reader: Reader,
}

impl Connection {
    fn end(&self) {
        // The client's own thread sees the end, and closes the connection.
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    fn takes(&self, source: &AppSrc) -> bool {
        let mut sockets = [PollFd::new(&self.socket, PollFlags::OUT)];
        // A socket that cannot be asked has an error, which its client meets with the next packet.
        let has_room = poll(&mut sockets, Some(&Timespec::default())).is_ok_and(|ready| ready > 0);
        has_room && source.current_level_bytes() < MAX_WAITING
    }
}

/// All connections.
pub(super) struct Audience(Mutex<State>);

struct State {
    /// The oldest first.
    connections: Vec<Connection>,
    /// The socket of the client that is just being made.
    arriving: Option<TcpStream>,
    to_program: Channel,
    told: Demand,
}

impl Audience {
    pub(super) const fn new(to_program: Channel) -> Self {
        let told = Demand::Nothing;
        Self(Mutex::new(State { connections: Vec::new(), arriving: None, to_program, told }))
    }

    /// A connection comes whose client will be made next.
    pub(super) fn await_client(&self, socket: TcpStream) {
        self.lock().arriving = Some(socket);
    }

    /// The client of the connection that has come.
    pub(super) fn arrive(&self, client: &RTSPClient) {
        let mut state = self.lock();
        if let Some(socket) = state.arriving.take() {
            let rests_since = Some(Instant::now());
            state.connections.push(Connection { client: client.clone(), socket, rests_since, feed: None });
        }
    }

    pub(super) fn leave(&self, client: &RTSPClient) {
        self.change(|state| state.connections.retain(|connection| connection.client != *client));
    }

    /// Whether there is room for a connection. Otherwise the oldest that has not shown that it may read is
    /// ended, and will have gone soon.
    pub(super) fn has_room(&self) -> bool {
        let state = self.lock();
        if state.connections.len() < MAX_CONNECTIONS {
            return true;
        }
        if let Some(oldest) = state.connections.iter().find(|connection| connection.feed.is_none()) {
            oldest.end();
        }
        false
    }

    /// Whether a client may become a reader, or is one.
    pub(super) fn may_read(&self, client: &RTSPClient) -> bool {
        let state = self.lock();
        let others = state.connections.iter().filter(|other| other.client != *client && other.feed.is_some());
        others.count() < MAX_READERS
    }

    /// A client asks what there is: units for it go into `source`.
    pub(super) fn describe(&self, client: &RTSPClient, source: AppSrc) {
        self.change(|state| {
            if let Some(connection) = state.of(client) {
                connection.feed = Some(Feed { source, reader: Reader::Describing });
                connection.rests_since = Some(Instant::now());
            }
        });
    }

    pub(super) fn play(&self, client: &RTSPClient) {
        self.change(|state| {
            if let Some(connection) = state.of(client)
                && let Some(feed) = &mut connection.feed
            {
                feed.reader.play();
                connection.rests_since = None;
            }
        });
    }

    pub(super) fn pause(&self, client: &RTSPClient) {
        self.change(|state| {
            if let Some(connection) = state.of(client)
                && let Some(feed) = &mut connection.feed
            {
                feed.reader.pause();
                connection.rests_since = Some(Instant::now());
            }
        });
    }

    /// Nothing reads from this source any more.
    pub(super) fn forget(&self, source: &AppSrc) {
        self.change(|state| {
            let is_its = |connection: &&mut Connection| {
                connection.feed.as_ref().is_some_and(|feed| feed.source == *source)
            };
            if let Some(connection) = state.connections.iter_mut().find(is_its) {
                connection.feed = None;
                connection.rests_since = Some(Instant::now());
            }
        });
    }

    /// Gives a unit to all readers that may have it. Never waits for a reader.
    pub(super) fn feed(&self, unit: Vec<u8>, is_key: bool) {
        let (unit, now) = (gst::Buffer::from_slice(unit), Instant::now());
        self.change(|state| {
            for connection in &mut state.connections {
                let Some(mut feed) = connection.feed.take() else { continue };
                let takes = connection.takes(&feed.source);
                if feed.reader.offer(is_key, takes, now) {
                    // A source that takes nothing more is about to be forgotten.
                    let _ = feed.source.push_buffer(unit.copy());
                }
                connection.feed = Some(feed);
            }
        });
    }

    /// Ends the connections that have done nothing for too long.
    pub(super) fn end_idle(&self) {
        for connection in &self.lock().connections {
            let most = if connection.feed.is_some() { MAX_REST } else { MAX_IDLE };
            if connection.rests_since.is_some_and(|since| since.elapsed() > most) {
                connection.end();
            }
        }
    }

    /// Changes the state, and tells the program what the readers need where that has changed.
    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.lock();
        change(&mut state);
        let feeds = state.connections.iter().filter_map(|connection| connection.feed.as_ref());
        let demand = feeds.map(|feed| feed.reader.demand()).max().unwrap_or_default();
        if demand != state.told {
            state.told = demand;
            // The main thread notices the end of the program.
            let _ = state.to_program.send(&FromShare::Demand(demand), &[]);
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn of(&mut self, client: &RTSPClient) -> Option<&mut Connection> {
        self.connections.iter_mut().find(|connection| connection.client == *client)
    }
}
