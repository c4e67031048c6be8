//! The socket of one page: requests in; snapshots, answers, events and video out.
//!
//! Reading and writing are two halves of one task, so that a page that stops reading can still stop the
//! camera. What is sent is always the newest: a slow page misses snapshots and video, and delays nobody. A
//! page that says what it has handled never gets more than it keeps up with.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytes::Bytes;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc, watch};
use tokio::time::{Instant, sleep, sleep_until, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, Role as SocketRole, WebSocketConfig};

use barrelman_vocab::{OperatorRequest, Request};

use super::access::{Pass, Role};
use super::api::{Answer, ClientMessage, ControlSeat, ServerMessage, VideoPath, WantedVideo};
use super::frame_counter::FrameCounter;
use super::in_flight::InFlight;
use super::left_moving::LeftMoving;
use super::limited_stream::LimitedStream;
use super::limits::{FRAMES, IDLE_TIMEOUT, MAX_MESSAGE_BYTES, READ_BYTES, SEND_TIMEOUT};
use super::pictures::PictureViewer;
use super::places::Place;
use super::requests::{Requester, answer, begin_request};
use super::seats::ClientId;
use super::shared::{Console, FAREWELL};
use super::video_relay::RelayedUnit;
use crate::snapshot::{EventEntry, SharedSnapshot};

/// Shortest time between two snapshots.
const SNAPSHOT_INTERVAL: Duration = Duration::from_millis(10);
/// Answers that wait to be sent. A page that reads none loses those beyond.
const OUTBOX: usize = 128;

/// The bytes of a socket, whose frames are counted.
type Stream = LimitedStream<TokioIo<Upgraded>, FrameCounter>;
type WebSocket = WebSocketStream<Stream>;

/// Serves one page until either side ends the connection, or the connection has to give way to another one.
pub(super) async fn serve(
    console: Arc<Console>,
    stream: TokioIo<Upgraded>,
    pass: Pass,
    name: String,
    place: Option<Arc<Place>>,
) {
    let clock = console.time.program_clock();
    let stream = LimitedStream::new(stream, FrameCounter::default(), FRAMES, clock);
    let is_over = stream.is_over();
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE_BYTES))
        .max_frame_size(Some(MAX_MESSAGE_BYTES))
        .read_buffer_size(READ_BYTES)
        // What is sent goes out at once: nothing is collected.
        .write_buffer_size(0);
    let socket = WebSocketStream::from_raw_socket(stream, SocketRole::Server, Some(config)).await;
    let id = console.join(&name, pass.clone());
    let (sink, stream) = socket.split();
    let (outbox, answers) = mpsc::channel(OUTBOX);
    let (path, paths) = watch::channel(WantedVideo::NONE);
    let (handled, handled_counts) = watch::channel(None);
    let requester = Requester { role: pass.role, client: Some(id), stops_taken: None };
    let reader = Reader {
        console: Arc::clone(&console),
        pass: pass.clone(),
        requester,
        outbox,
        path,
        handled,
        is_over,
    };
    let said = Said { answers, paths, handled: handled_counts };
    tokio::select! {
        () = reader.run(stream) => {}
        _ = write(&console, sink, (id, &pass), said) => {}
        () = gives_way(place) => {}
        () = is_signed_out(&console, &pass) => {}
    }
    console.leave(id);
}

/// Waits until a pass does not hold any more, and then until the page has had the time to take the reason.
async fn is_signed_out(console: &Console, pass: &Pass) {
    let mut seats = console.seat_changes.subscribe();
    let _ = seats.wait_for(|_| !console.access.holds(pass)).await;
    sleep(FAREWELL).await;
}

/// Waits until the connection has to give way to another one.
async fn gives_way(place: Option<Arc<Place>>) {
    match place {
        Some(place) => place.gives_way().await,
        None => std::future::pending().await,
    }
}

/// The half that reads.
struct Reader {
    console: Arc<Console>,
    pass: Pass,
    requester: Requester,
    outbox: mpsc::Sender<ServerMessage>,
    path: watch::Sender<WantedVideo>,
    /// How many snapshots and video messages the page has handled; `None` until it says so.
    handled: watch::Sender<Option<u64>>,
    /// Whether the page has sent more frames than it may.
    is_over: Arc<AtomicBool>,
}

impl Reader {
    /// Reads until the page is gone, silent for too long, or breaks the rules.
    async fn run(self, mut stream: SplitStream<WebSocket>) {
        while let Ok(Some(Ok(message))) = timeout(IDLE_TIMEOUT, stream.next()).await {
            let text = match message {
                Message::Text(text) => text,
                Message::Ping(_) | Message::Pong(_) => continue,
                Message::Binary(_) | Message::Close(_) | Message::Frame(_) => break,
            };
            let message = match serde_json::from_str::<ClientMessage>(&text) {
                Ok(message) => message,
                Err(error) => {
                    tracing::warn!("a page sent a message that cannot be read ({error}); it is disconnected");
                    break;
                }
            };
            let is_signed_out = !self.console.access.holds(&self.pass);
            if is_signed_out {
                // A cookie also ends where a newer one takes its place.
                self.console.sign_out();
            }
            if is_signed_out || self.is_over.load(Ordering::Relaxed) {
                // The connection ends soon. A stop that comes before is taken, and nothing else.
                if matches!(
                    message,
                    ClientMessage::Request { request: Request::Operator(OperatorRequest::Stop(_)), .. }
                ) {
                    self.console.gateway.stop();
                }
                continue;
            }
            if let Some(client) = self.requester.client {
                self.console.with_seats(|seats| seats.hear(client, self.console.time.clock()));
                self.console.watch_vessel();
            }
            self.on_message(message);
        }
        if self.is_over.load(Ordering::Relaxed) {
            tracing::warn!("a page sent too many messages; it is disconnected");
        }
    }

    fn on_message(&self, message: ClientMessage) {
        match message {
            ClientMessage::Request { id, request, stops_taken } => {
                let requester = Requester { stops_taken, ..self.requester };
                let pending = begin_request(&self.console, requester, request);
                let (console, outbox) = (Arc::clone(&self.console), self.outbox.clone());
                tokio::spawn(async move {
                    let (answer, reason) = answer(&console, pending).await;
                    let _ = outbox.try_send(ServerMessage::Answer(Answer { id, answer, reason }));
                });
            }
            ClientMessage::Video(wanted) => drop(self.path.send_replace(wanted)),
            ClientMessage::Ping { sent_ms, handled } => {
                if handled.is_some() {
                    self.handled.send_replace(handled);
                }
                let now_ns = self.console.time.now().as_nanos();
                let _ = self.outbox.try_send(ServerMessage::Pong { sent_ms, now_ns, sent: 0 });
            }
        }
    }
}

/// The connection is over.
struct Closed;

/// The half that writes.
struct Writer {
    sink: SplitSink<WebSocket, Message>,
}

impl Writer {
    async fn send(&mut self, message: Message) -> Result<(), Closed> {
        match timeout(SEND_TIMEOUT, self.sink.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(Closed),
        }
    }

    async fn send_json(&mut self, message: &ServerMessage) -> Result<(), Closed> {
        let text = serde_json::to_string(message).map_err(|_| Closed)?;
        self.send(Message::Text(text.into())).await
    }

    /// Sends what the page is, and the events so far; returns the later ones.
    async fn greet(
        &mut self,
        console: &Console,
        id: ClientId,
        role: Role,
    ) -> Result<broadcast::Receiver<EventEntry>, Closed> {
        self.send_json(&ServerMessage::Hello(Box::new(console.hello(id, role)))).await?;
        let (events, later_events) = console.events.subscribe();
        self.send_json(&ServerMessage::Events { events }).await?;
        Ok(later_events)
    }

    /// Sends who has the control, or dismisses a page that lost its seat.
    async fn send_seat(&mut self, seat: ControlSeat, id: ClientId) -> Result<(), Closed> {
        if seat.clients.contains(&id) {
            return self.send_json(&ServerMessage::Control(seat)).await;
        }
        dismiss(self, CloseCode::Again, "too many pages are open").await
    }

    /// Sends what waited in the outbox. How much was sent before a pong is known only now: snapshots and
    /// video overtake what waits.
    async fn send_answer(&mut self, mut message: ServerMessage, in_flight: &InFlight) -> Result<(), Closed> {
        if let ServerMessage::Pong { sent, .. } = &mut message {
            *sent = in_flight.sent();
        }
        self.send_json(&message).await
    }
}

/// What the reading half has for the writing one.
struct Said {
    answers: mpsc::Receiver<ServerMessage>,
    paths: watch::Receiver<WantedVideo>,
    handled: watch::Receiver<Option<u64>>,
}

/// Writes until the page is gone, or has to go.
async fn write(
    console: &Arc<Console>,
    sink: SplitSink<WebSocket, Message>,
    (id, pass): (ClientId, &Pass),
    Said { mut answers, mut paths, mut handled }: Said,
) -> Result<(), Closed> {
    let mut writer = Writer { sink };
    let mut snapshots = console.snapshots.clone();
    let mut seats = console.seat_changes.subscribe();
    let mut ending = console.ending.subscribe();
    let mut later_events = writer.greet(console, id, pass.role).await?;
    seats.mark_changed();
    snapshots.mark_changed();
    let mut video = VideoFeed::None;
    let mut snapshot_at = Instant::now();
    let mut in_flight = InFlight::default();
    loop {
        let is_full = in_flight.is_full(Instant::now());
        let takes_video = !is_full && in_flight.videos() < video.max_ahead();
        tokio::select! {
            biased;
            message = answers.recv() => {
                writer.send_answer(message.ok_or(Closed)?, &in_flight).await?;
            }
            changed = seats.changed() => {
                changed.map_err(|_| Closed)?;
                let seat = seats.borrow_and_update().clone();
                if !console.access.holds(pass) {
                    return dismiss(&mut writer, CloseCode::Policy, "signed out").await;
                }
                writer.send_seat(seat, id).await?;
            }
            left = ends(&mut ending) => {
                return dismiss(&mut writer, CloseCode::Away, left.reason()).await;
            }
            changed = handled.changed() => {
                changed.map_err(|_| Closed)?;
                if let Some(count) = *handled.borrow_and_update() {
                    in_flight.on_handled(count, Instant::now());
                }
            }
            () = newest(&mut snapshots, snapshot_at), if !is_full => {
                snapshot_at = Instant::now() + SNAPSHOT_INTERVAL;
                in_flight.add(false);
                let status = console.status_of(&snapshots.borrow_and_update());
                writer.send_json(&ServerMessage::Snapshot(Box::new(status))).await?;
            }
            event = next_event(&mut later_events) => {
                writer.send_json(&ServerMessage::Event(event)).await?;
            }
            changed = paths.changed() => {
                changed.map_err(|_| Closed)?;
                video = VideoFeed::begin(*paths.borrow_and_update(), console);
            }
            message = video.next(), if takes_video => match message {
                Some(message) => {
                    in_flight.add(true);
                    writer.send(Message::Binary(message)).await?;
                }
                None => video = VideoFeed::None,
            },
        }
    }
}

/// Waits until the program ends.
async fn ends(ending: &mut watch::Receiver<Option<LeftMoving>>) -> LeftMoving {
    let left = ending.wait_for(Option::is_some).await.ok();
    left.and_then(|left| *left).unwrap_or(LeftMoving::NOT_KNOWN)
}

/// Tells a page why its connection ends.
async fn dismiss(writer: &mut Writer, code: CloseCode, reason: &'static str) -> Result<(), Closed> {
    let frame = CloseFrame { code, reason: reason.into() };
    let _ = writer.send(Message::Close(Some(frame))).await;
    Err(Closed)
}

/// Waits for the newest snapshot. After the run there is none; the page stays connected until it is told of
/// the program's end.
async fn newest(snapshots: &mut watch::Receiver<SharedSnapshot>, not_before: Instant) {
    sleep_until(not_before).await;
    if snapshots.changed().await.is_err() {
        std::future::pending().await
    }
}

/// The next event; events that came too fast for this page are left out. Waits for ever after the run.
async fn next_event(events: &mut broadcast::Receiver<EventEntry>) -> EventEntry {
    loop {
        match events.recv().await {
            Ok(event) => return event,
            Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => std::future::pending().await,
        }
    }
}

/// The video of one page.
enum VideoFeed {
    None,
    Jpeg(PictureViewer),
    Encoded {
        /// Units of the group of pictures that is going on, next one last.
        group: Vec<RelayedUnit>,
        units: broadcast::Receiver<RelayedUnit>,
        /// Whether units are left out until the next key frame.
        waits_for_key: bool,
    },
}

impl VideoFeed {
    /// The video in the way that a page wants; none where there is no such video.
    fn begin(wanted: WantedVideo, console: &Console) -> Self {
        let Some(outlet) = console.videos.get(wanted.video) else { return Self::None };
        match wanted.path {
            VideoPath::None => Self::None,
            VideoPath::Jpeg => Self::Jpeg(PictureViewer::new(Arc::clone(&outlet.pictures))),
            VideoPath::H264 | VideoPath::H265 => {
                let (mut group, units) = outlet.relay.subscribe();
                group.reverse();
                let waits_for_key = group.is_empty();
                Self::Encoded { group, units, waits_for_key }
            }
        }
    }

    /// Messages that may be under way: a further picture would only grow old, while every unit is decoded.
    const fn max_ahead(&self) -> usize {
        match self {
            Self::None | Self::Encoded { .. } => usize::MAX,
            Self::Jpeg(_) => 1,
        }
    }

    /// The next message. Waits for ever where no video is sent; `None` at the end of the session.
    async fn next(&mut self) -> Option<Bytes> {
        match self {
            Self::None => std::future::pending().await,
            Self::Jpeg(viewer) => viewer.next().await,
            Self::Encoded { group, units, waits_for_key } => {
                if let Some(unit) = group.pop() {
                    return Some(unit.message);
                }
                loop {
                    match units.recv().await {
                        Ok(unit) if unit.key || !*waits_for_key => {
                            *waits_for_key = false;
                            return Some(unit.message);
                        }
                        Ok(_) => {}
                        Err(RecvError::Lagged(_)) => *waits_for_key = true,
                        Err(RecvError::Closed) => return None,
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
