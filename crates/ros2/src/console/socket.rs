//! The console's socket: state and pictures in; pings, the wish for pictures and stops out.

use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail};
use barrelman_vocab::{OperatorRequest, Request, SeatRequest, StopCause};
use bytes::Bytes;
use futures_util::{SinkExt as _, StreamExt as _};
use hyper::header::AUTHORIZATION;
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{WebSocketStream, client_async_with_config};

use super::api::{AnswerKind, Control, Hello, Pong, ServerMessage, Snapshot};
use super::line::{Line, Stream};
use crate::stops::Stops;

const PATH: &str = "/api/v1/socket";
/// Largest message, bytes: a JPEG picture.
const MAX_MESSAGE_BYTES: usize = 16 << 20;
/// Bytes that wait for a console that does not read, at most. What is beyond ends the connection.
const MAX_UNSENT_BYTES: usize = 256 << 10;
const OPEN_TIMEOUT: Duration = Duration::from_secs(4);
const SEND_TIMEOUT: Duration = Duration::from_secs(2);
/// The console sends something at least once a second.
const SILENCE: Duration = Duration::from_secs(3);
/// Between pings without pictures. The console sends no more ahead than was said to be handled.
const PING_INTERVAL: Duration = Duration::from_millis(200);
/// The number of requests that are no stop.
const NO_STOP: u64 = 0;

/// What came from the console.
#[derive(Debug)]
pub enum Event {
    /// The connection is open.
    Hello(Hello),
    /// The newest state.
    Snapshot(Box<Snapshot>),
    /// A binary message: a unit of video.
    Video(Bytes),
    /// The answer to a ping that was sent at this time of the wall, milliseconds since 1970.
    Pong(Pong),
}

/// The console does not know the token: another attempt would not help.
#[derive(Debug)]
pub struct TokenRefused;

impl std::fmt::Display for TokenRefused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(
            "the console does not accept the token: give --token-file a file with its control token or its \
             watch token (`barrelman run` prints them; the service keeps them in \
             /var/lib/barrelman/console-tokens)",
        )
    }
}

impl std::error::Error for TokenRefused {}

type Socket = WebSocketStream<Box<dyn Stream>>;

/// Opens a connection and serves it until it ends.
///
/// # Errors
/// Why the connection ended; [`TokenRefused`].
pub async fn serve(
    line: &Line,
    stops: &Stops,
    wants_pictures: watch::Receiver<bool>,
    wall_ms: fn() -> f64,
    on_event: &mut impl FnMut(Event),
) -> Result<()> {
    let opened = timeout(OPEN_TIMEOUT, open(line)).await;
    let socket = opened.map_err(|_| anyhow!("no answer within {} s", OPEN_TIMEOUT.as_secs()))??;
    let session = Session { socket, client: None, handled: 0, wall_ms, on_event, stops };
    session.run(wants_pictures).await
}

async fn open(line: &Line) -> Result<Socket> {
    let stream = line.open().await?;
    // The scheme names no encryption here: the stream has it.
    let mut request = format!("ws://{}{PATH}", line.authority()).into_client_request()?;
    if let Some(value) = line.authorization() {
        request.headers_mut().insert(AUTHORIZATION, value.clone());
    }
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE_BYTES))
        .max_frame_size(Some(MAX_MESSAGE_BYTES))
        .write_buffer_size(0)
        .max_write_buffer_size(MAX_UNSENT_BYTES);
    match client_async_with_config(request, stream, Some(config)).await {
        Ok((socket, _)) => Ok(socket),
        Err(Error::Http(answer)) if answer.status() == 401 => Err(TokenRefused.into()),
        Err(Error::Http(answer)) => bail!("the console answers {}", answer.status()),
        Err(error) => Err(error.into()),
    }
}

/// An open connection.
struct Session<'a, F> {
    socket: Socket,
    client: Option<u64>,
    /// Snapshots and units of video that were handled.
    handled: u64,
    wall_ms: fn() -> f64,
    on_event: &'a mut F,
    stops: &'a Stops,
}

impl<F: FnMut(Event)> Session<'_, F> {
    async fn run(mut self, mut wants_pictures: watch::Receiver<bool>) -> Result<()> {
        let mut pings = interval(PING_INTERVAL);
        pings.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut presses = self.stops.presses();
        presses.mark_changed();
        wants_pictures.mark_changed();
        let mut heard = Instant::now();
        loop {
            tokio::select! {
                biased;
                changed = presses.changed() => {
                    changed?;
                    let number = *presses.borrow_and_update();
                    if self.stops.is_pending() {
                        self.request(number, OperatorRequest::Stop(StopCause::Operator).into()).await?;
                    }
                }
                message = self.socket.next() => {
                    heard = Instant::now();
                    self.on_message(message.context("the console closed the connection")??).await?;
                }
                changed = wants_pictures.changed() => {
                    changed?;
                    let path = if *wants_pictures.borrow_and_update() { "jpeg" } else { "none" };
                    self.send(json!({ "type": "video", "path": path })).await?;
                }
                _ = pings.tick() => {
                    if heard.elapsed() > SILENCE {
                        bail!("the console was silent for {} s", SILENCE.as_secs());
                    }
                    self.ping().await?;
                }
            }
        }
    }

    async fn on_message(&mut self, message: Message) -> Result<()> {
        match message {
            Message::Text(text) => {
                let message =
                    serde_json::from_str(&text).context("a message of the console cannot be read")?;
                self.on_server_message(message).await
            }
            Message::Binary(unit) => {
                self.handled += 1;
                (self.on_event)(Event::Video(unit));
                // The next picture comes once this one was handled.
                self.ping().await
            }
            Message::Close(_) => bail!("the console closed the connection"),
            Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => Ok(()),
        }
    }

    async fn on_server_message(&mut self, message: ServerMessage) -> Result<()> {
        match message {
            ServerMessage::Hello(hello) => {
                self.client = Some(hello.client);
                (self.on_event)(Event::Hello(hello));
            }
            ServerMessage::Snapshot(snapshot) => {
                self.handled += 1;
                (self.on_event)(Event::Snapshot(snapshot));
            }
            ServerMessage::Pong(pong) => (self.on_event)(Event::Pong(pong)),
            ServerMessage::Answer(answer) if answer.answer == AnswerKind::Accepted => {
                self.stops.confirm(answer.id)
            }
            // The console gives an empty seat to whoever connects. The seat is for a person's page.
            ServerMessage::Control(Control { holder }) if holder.is_some() && holder == self.client => {
                self.request(NO_STOP, SeatRequest::ReleaseControl.into()).await?;
            }
            ServerMessage::Answer(_) | ServerMessage::Control(_) | ServerMessage::Other => {}
        }
        Ok(())
    }

    async fn ping(&mut self) -> Result<()> {
        self.send(json!({ "type": "ping", "sent_ms": (self.wall_ms)(), "handled": self.handled })).await
    }

    async fn request(&mut self, id: u64, request: Request) -> Result<()> {
        self.send(json!({ "type": "request", "id": id, "request": request })).await
    }

    async fn send(&mut self, message: Value) -> Result<()> {
        let sent = timeout(SEND_TIMEOUT, self.socket.send(Message::text(message.to_string()))).await;
        Ok(sent.context("the console does not read")??)
    }
}
