//! H.264 over RTSP (RFC 2326), interleaved in the TCP connection, so that nothing is lost or out of order.
//!
//! This file moves bytes; when to connect and when to give up is decided in [`super::supervision`]. Each connection
//! has an asynchronous runtime of its own that ends with it, so that nothing of a lost one is left behind.
//! Not handled: RTP over UDP, TLS, other codecs, several video streams in one session (the first H.264 is taken).

use std::pin::{Pin, pin};
use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt;
use retina::client::{
    Credentials, Demuxed, PlayOptions, Session, SessionOptions, SetupOptions, TcpTransportOptions, Transport,
};
use retina::codec::{CodecItem, FrameFormat};
use tokio::runtime::{Builder, Runtime};
use tokio::time::{Instant, timeout_at};
use url::Url;

use super::feed::{Feed, StopSignal};
use super::rtp_clock::RtpClock;
use super::sink::{VideoSink, VideoState};
use super::supervision::{Action, Event, Loss, State, Supervision};
use super::url::Login;
use crate::error::VideoError;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// How often the thread looks whether it must end, and whether a fault is due.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// How long a server is given to hear that we hang up.
const TEARDOWN_TIMEOUT: Duration = Duration::from_millis(100);

/// Receives until the thread must end or the stream can never be shown.
pub(super) fn run<S: VideoSink>(address: &Url, login: Option<&Login>, feed: Feed<S>, stop: &StopSignal) {
    let supervision = Supervision::new(feed.clock.now());
    let mut receiver = Receiver { feed, supervision, stop, epoch: 0, units: 0, was_up: false };
    loop {
        let wake_at = receiver.feed.clock.instant(receiver.supervision.wake_at());
        if stop.wait_until(wake_at) {
            return;
        }
        if receiver.tell(Event::Tick) != Some(Action::Connect) {
            continue;
        }
        let runtime = match Builder::new_current_thread().enable_all().build() {
            Ok(runtime) => runtime,
            Err(error) => return receiver.feed.fail(VideoError::Thread(error)),
        };
        let end = runtime.block_on(receiver.connection(address, login));
        tear_down(runtime);
        receiver.epoch += 1;
        match end {
            End::Stopped => return,
            End::Lost(reason) => receiver.feed.sink.state(VideoState::Lost { reason }),
            End::Final(error) if !receiver.was_up => return receiver.feed.fail(error),
            // It was shown before: somebody changed its settings, and may change them back.
            End::Final(error) => {
                receiver.tell(Event::Broken);
                receiver.feed.sink.state(VideoState::Lost { reason: error.to_string() });
            }
        }
    }
}

/// Lets the session say goodbye, and then ends whatever is left of it.
fn tear_down(runtime: Runtime) {
    runtime.block_on(async { tokio::time::sleep(TEARDOWN_TIMEOUT).await });
    runtime.shutdown_background();
}

/// How a connection ended.
enum End {
    Stopped,
    Lost(String),
    Final(VideoError),
}

/// A connection that is being made or is there.
enum Link<'a> {
    Connecting(Pin<&'a mut dyn Future<Output = Result<Demuxed, Refusal>>>),
    Up(Box<Demuxed>, RtpClock),
}

/// Why no session came about.
enum Refusal {
    /// It may work next time.
    ForNow(String),
    /// It will not work next time either.
    ForGood(VideoError),
}

/// What the link brought.
enum LinkEvent {
    /// Time passed.
    Nothing,
    Connected(Box<Demuxed>),
    Item(CodecItem),
    Broken(Refusal),
}

struct Receiver<'a, S> {
    feed: Feed<S>,
    supervision: Supervision,
    stop: &'a StopSignal,
    epoch: u32,
    units: u64,
    was_up: bool,
}

impl<S: VideoSink> Receiver<'_, S> {
    fn tell(&mut self, event: Event) -> Option<Action> {
        self.supervision.handle(event, self.feed.clock.now())
    }

    /// One connection, from the attempt to its end.
    async fn connection(&mut self, address: &Url, login: Option<&Login>) -> End {
        self.feed.sink.state(VideoState::Connecting);
        let place = self.feed.place.clone();
        let attempt = pin!(connect(address, login, &place));
        let mut link = Link::Connecting(attempt);
        loop {
            let wake_at = self.supervision.wake_at().min(self.feed.clock.now().plus(POLL_INTERVAL));
            let event = link.next(self.feed.clock.instant(wake_at).into()).await;
            if self.stop.is_raised() {
                return End::Stopped;
            }
            let cut = self.feed.faults.is_disconnected(self.feed.clock.now());
            let action = match event {
                _ if cut => {
                    self.tell(Event::Broken);
                    return End::Lost("the connection is cut on purpose".to_owned());
                }
                LinkEvent::Nothing => match self.take(None) {
                    Ok(()) => self.tell(Event::Tick),
                    Err(end) => return end,
                },
                LinkEvent::Connected(session) => {
                    link = Link::Up(session, RtpClock::new(CLOCK_RATE));
                    self.tell(Event::Connected)
                }
                LinkEvent::Item(item) => match self.take_item(item, &mut link) {
                    Ok(()) => self.tell(Event::Tick),
                    Err(end) => return end,
                },
                LinkEvent::Broken(Refusal::ForGood(error)) => return End::Final(error),
                LinkEvent::Broken(Refusal::ForNow(reason)) => {
                    self.tell(Event::Broken);
                    return End::Lost(reason);
                }
            };
            if let Some(Action::HangUp(loss)) = action {
                return End::Lost(loss.to_string());
            }
        }
    }

    fn take_item(&mut self, item: CodecItem, link: &mut Link<'_>) -> Result<(), End> {
        let Link::Up(_, rtp_clock) = link else { return Ok(()) };
        match item {
            CodecItem::VideoFrame(video) => {
                // Only the low 32 bits are the sender's.
                let rtp = video.timestamp().timestamp() as u32;
                // The last packet of a picture is what makes it whole, but the first is nearest to its capture.
                let arrival = self.feed.clock.at(video.start_ctx().received());
                let capture = rtp_clock.capture(rtp, arrival);
                let unit = EncodedUnit {
                    epoch: self.epoch,
                    index: self.units,
                    capture,
                    key: video.is_random_access_point(),
                    shown: true,
                    rotation: Rotation::None,
                    codec: UnitCodec::H264AnnexB,
                    payload: Bytes::from(video.into_data()),
                };
                self.units += 1;
                self.take(Some(unit))
            }
            CodecItem::Rtcp(report) => {
                if let Some(timestamp) = report.rtp_timestamp() {
                    let arrival = self.feed.clock.at(report.ctx().received());
                    rtp_clock.report(timestamp.timestamp() as u32, arrival);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// A unit, or none but time, through faults and decoder to the sink.
    fn take(&mut self, unit: Option<EncodedUnit>) -> Result<(), End> {
        let decoded = self.feed.decode(unit);
        for unit in &decoded.units {
            self.feed.sink.unit(unit);
            self.tell(Event::Unit);
        }
        for frame in decoded.frames {
            if !matches!(self.supervision.state(), State::Up { .. }) {
                self.feed.sink.state(VideoState::Up);
            }
            self.was_up = true;
            self.tell(Event::Picture);
            self.feed.sink.frame(frame);
        }
        match decoded.error {
            None => Ok(()),
            Some(source) if source.is_final() => {
                let place = self.feed.place.clone();
                Err(End::Final(VideoError::Decode { place, cause: source }))
            }
            Some(_) => {
                self.tell(Event::KeyNeeded);
                Ok(())
            }
        }
    }
}

/// Ticks of RTP time per second of every H.264 stream (RFC 6184, 8.2.1).
const CLOCK_RATE: u32 = 90_000;

impl Link<'_> {
    async fn next(&mut self, until: Instant) -> LinkEvent {
        match self {
            Self::Connecting(attempt) => match timeout_at(until, attempt.as_mut()).await {
                Err(_) => LinkEvent::Nothing,
                Ok(Ok(session)) => LinkEvent::Connected(Box::new(session)),
                Ok(Err(refusal)) => LinkEvent::Broken(refusal),
            },
            Self::Up(session, _) => match timeout_at(until, session.next()).await {
                Err(_) => LinkEvent::Nothing,
                Ok(Some(Ok(item))) => LinkEvent::Item(item),
                Ok(Some(Err(error))) => LinkEvent::Broken(Refusal::ForNow(error.to_string())),
                Ok(None) => LinkEvent::Broken(Refusal::ForNow(Loss::Broken.to_string())),
            },
        }
    }
}

async fn connect(address: &Url, login: Option<&Login>, place: &str) -> Result<Demuxed, Refusal> {
    let credentials =
        login.map(|login| Credentials { username: login.user.clone(), password: login.password.clone() });
    let options = SessionOptions::default().creds(credentials).user_agent("barrelman".to_owned());
    let refused = |error: retina::Error| match error.status_code() {
        Some(401 | 403) => for_good(
            place,
            "does not let us in",
            "Write USER:PASSWORD on the first line of a file and give --video-login-file FILE, or name the file as \
             video.login_file in the configuration",
        ),
        _ => Refusal::ForNow(error.to_string()),
    };
    let mut session = Session::describe(address.clone(), options).await.map_err(refused)?;
    let is_video = |stream: &&retina::client::Stream| stream.media() == "video";
    let is_h264 =
        |stream: &retina::client::Stream| stream.media() == "video" && stream.encoding_name() == "h264";
    let Some(stream) = session.streams().iter().position(is_h264) else {
        let found =
            session.streams().iter().find(is_video).map(|stream| stream.encoding_name().to_uppercase());
        let what = found
            .map_or("offers no video".to_owned(), |codec| format!("sends {codec}, and only H.264 is read"));
        return Err(for_good(place, &what, "Set the camera, or this profile of it, to H.264"));
    };
    let transport = Transport::Tcp(TcpTransportOptions::default());
    let setup = SetupOptions::default().transport(transport).frame_format(FrameFormat::SIMPLE);
    session.setup(stream, setup).await.map_err(refused)?;
    let playing = session.play(PlayOptions::default()).await.map_err(refused)?;
    playing.demuxed().map_err(refused)
}

fn for_good(place: &str, what: &str, remedy: &str) -> Refusal {
    Refusal::ForGood(VideoError::Stream {
        place: place.to_owned(),
        what: what.to_owned(),
        remedy: remedy.to_owned(),
    })
}
