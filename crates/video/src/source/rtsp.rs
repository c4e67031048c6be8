//! Receives H.264 over RTSP (RFC 2326), interleaved in the TCP connection, so that no packet is lost or out of order.
//!
//! This module moves bytes; [`super::supervision`] decides when to connect and when to disconnect. Each connection has an
//! asynchronous runtime of its own, which ends with the connection and leaves no task behind. Not handled: RTP over UDP,
//! TLS, other codecs, several video streams in one session (the first H.264 stream is used).

use std::pin::{Pin, pin};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use bytes::Bytes;
use futures_util::StreamExt;
use retina::client::{
    Credentials, Demuxed, PlayOptions, Session, SessionOptions, SetupOptions, TcpTransportOptions, Transport,
};
use retina::codec::{CodecItem, FrameFormat};
use retina::rtcp::ReceivedCompoundPacket;
use tokio::runtime::{Builder, Runtime};
use tokio::time::{Instant, timeout_at};
use url::Url;

use super::feed::{Feed, StopSignal};
use super::rtsp_filter::Refusal;
use super::rtsp_relay::{self, RelayEnd};
use super::sender_clock::{ArrivedPicture, SenderClock, SenderReport, VideoTiming};
use super::sink::{VideoSink, VideoState};
use super::supervision::{Action, Event, Loss, State, Supervision};
use super::url::Login;
use crate::error::VideoError;
use barrelman_host::clock::Clock;
use barrelman_host::suspend::SuspendWatch;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// Interval of the checks for the stop signal, a cut line and delayed units.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Time for the session to send its TEARDOWN to the server.
const TEARDOWN_TIMEOUT: Duration = Duration::from_millis(100);

/// Receives until the stop signal, or until the stream turns out to be unusable.
pub(super) fn run<S: VideoSink>(address: &Url, login: Option<&Login>, feed: Feed<S>, stop: &StopSignal) {
    let supervision = Supervision::new(feed.clock.now());
    let clock = SenderClock::new(CLOCK_RATE, feed.timing);
    let timing = VideoTiming::default();
    let suspensions = SuspendWatch::start();
    let mut receiver =
        Receiver { feed, supervision, clock, timing, suspensions, stop, epoch: 0, units: 0, was_up: false };
    loop {
        let wake_at = receiver.feed.clock.instant(receiver.supervision.wake_at());
        if stop.wait_until(wake_at) {
            return;
        }
        if receiver.notify(Event::Tick) != Some(Action::Connect) {
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
            End::Lost(reason) => receiver.feed.sink.on_state(VideoState::Lost { reason }),
            End::Final(error) if !receiver.was_up => return receiver.feed.fail(error),
            // The stream was usable before: its settings were changed and may be changed back.
            End::Final(error) => {
                receiver.notify(Event::Broken);
                receiver.feed.sink.on_state(VideoState::Lost { reason: error.to_string() });
            }
        }
    }
}

/// Lets the session send its TEARDOWN, then ends its tasks.
fn tear_down(runtime: Runtime) {
    runtime.block_on(async { tokio::time::sleep(TEARDOWN_TIMEOUT).await });
    runtime.shutdown_background();
}

/// The end of a connection.
enum End {
    Stopped,
    Lost(String),
    Final(VideoError),
}

/// A connection, or an attempt to connect.
enum Connection<'a> {
    Connecting(Pin<&'a mut dyn Future<Output = Result<(Demuxed, RelayEnd), ConnectError>>>),
    Up(Box<Demuxed>, RelayEnd),
}

/// A failed attempt to connect, or a broken connection.
enum ConnectError {
    /// The next attempt may succeed.
    Temporary(String),
    /// No further attempt can succeed.
    Permanent(VideoError),
}

/// An event of a connection.
enum ConnectionEvent {
    /// No event before the timeout.
    Timeout,
    Connected(Box<Demuxed>, RelayEnd),
    Item(CodecItem),
    Broken(ConnectError),
}

struct Receiver<'a, S> {
    feed: Feed<S>,
    supervision: Supervision,
    clock: SenderClock,
    /// What the sink knows of the times.
    timing: VideoTiming,
    suspensions: SuspendWatch,
    stop: &'a StopSignal,
    epoch: u32,
    units: u64,
    was_up: bool,
}

impl<S: VideoSink> Receiver<'_, S> {
    fn notify(&mut self, event: Event) -> Option<Action> {
        self.supervision.handle(event, self.feed.clock.now())
    }

    /// Runs one connection, from the attempt to the end.
    async fn connection(&mut self, address: &Url, login: Option<&Login>) -> End {
        self.feed.sink.on_state(VideoState::Connecting);
        let shown_address = self.feed.address.clone();
        let attempt = pin!(connect(address, login, &shown_address));
        let mut connection = Connection::Connecting(attempt);
        loop {
            let wake_at = self.supervision.wake_at().min(self.feed.clock.now().plus(POLL_INTERVAL));
            let event = connection.next(self.feed.clock.instant(wake_at).into()).await;
            if self.stop.is_raised() {
                return End::Stopped;
            }
            if let Some(reason) = self.feed.faults.as_ref().and_then(|path| path.cut(self.feed.clock.now())) {
                self.notify(Event::Broken);
                return End::Lost(reason.to_owned());
            }
            let action = match event {
                ConnectionEvent::Timeout => match self.deliver(None) {
                    Ok(()) => self.notify(Event::Tick),
                    Err(end) => return end,
                },
                ConnectionEvent::Connected(session, relay) => {
                    connection = Connection::Up(session, relay);
                    self.clock.on_connected();
                    self.notify(Event::Connected)
                }
                ConnectionEvent::Item(item) => match self.on_item(item) {
                    Ok(()) => self.judge_times(),
                    Err(end) => return end,
                },
                ConnectionEvent::Broken(ConnectError::Permanent(error)) => return End::Final(error),
                ConnectionEvent::Broken(ConnectError::Temporary(reason)) => {
                    self.notify(Event::Broken);
                    return End::Lost(reason);
                }
            };
            if let Some(Action::Disconnect(loss)) = action {
                return End::Lost(loss.to_string());
            }
        }
    }

    fn on_item(&mut self, item: CodecItem) -> Result<(), End> {
        if let Some(gap) = self.suspensions.check() {
            self.clock.on_suspension(gap);
        }
        match item {
            CodecItem::VideoFrame(video) => {
                // The sender's RTP time is in the low 32 bits.
                let rtp = video.timestamp().timestamp() as u32;
                // The arrival of the first packet of a picture is nearest to its capture.
                let arrival = self.feed.clock.at(video.start_ctx().received());
                let bytes = video.data().len();
                let capture = self.clock.capture(ArrivedPicture { rtp, bytes, arrival });
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
                self.deliver(Some(unit))
            }
            CodecItem::Rtcp(report) => {
                for report in sender_reports(&report, self.feed.clock) {
                    self.clock.on_sender_report(report);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Tells the sink what the times of the pictures say, where that changed. A delay that stays ends the connection.
    fn judge_times(&mut self) -> Option<Action> {
        let timing = self.clock.timing();
        if timing.differs_from(self.timing) {
            self.timing = timing;
            self.feed.sink.on_timing(timing);
        }
        match timing {
            VideoTiming::Late { since, .. } => self.notify(Event::Late { since }),
            VideoTiming::InTime | VideoTiming::ClockWrong(_) => self.notify(Event::Tick),
        }
    }

    /// Passes a unit, or the delayed units that are due, through the decoder to the sink.
    fn deliver(&mut self, unit: Option<EncodedUnit>) -> Result<(), End> {
        let decoded = self.feed.decode(unit);
        for unit in &decoded.units {
            self.feed.sink.on_unit(unit);
            self.notify(Event::Unit);
        }
        for frame in decoded.frames {
            if !matches!(self.supervision.state(), State::Up { .. }) {
                self.feed.sink.on_state(VideoState::Up);
            }
            self.was_up = true;
            self.notify(Event::Picture);
            self.feed.sink.on_frame(frame);
        }
        match decoded.error {
            None => Ok(()),
            Some(source) if source.is_final() => {
                let address = self.feed.address.clone();
                Err(End::Final(VideoError::Decode { address, cause: source }))
            }
            Some(_) => {
                self.notify(Event::KeyNeeded);
                Ok(())
            }
        }
    }
}

/// Ticks of RTP time per second of an H.264 stream (RFC 6184, 8.2.1).
const CLOCK_RATE: u32 = 90_000;

/// Nanoseconds from 1900, where NTP time begins (RFC 5905), to 1970, where Unix time begins.
const UNIX_EPOCH_SINCE_1900_NS: i128 = 2_208_988_800 * 1_000_000_000;

/// The sender reports of a packet.
fn sender_reports(packet: &ReceivedCompoundPacket, clock: Clock) -> impl Iterator<Item = SenderReport> {
    let received = packet.ctx().received();
    let arrival = clock.at(received);
    let unix = SystemTime::now().checked_sub(received.elapsed()).unwrap_or(UNIX_EPOCH);
    let unix_ns = unix.duration_since(UNIX_EPOCH).map_or(0, |unix| unix.as_nanos() as i128);
    packet.pkts().filter_map(|packet| packet.as_sender_report().ok().flatten()).map(move |report| {
        // Seconds in the upper half, fractions of 2^-32 s in the lower. 0: the sender has no wall clock.
        let ntp = report.ntp_timestamp().0;
        let ntp_ns = (i128::from(ntp) * 1_000_000_000) >> 32;
        SenderReport {
            rtp: report.rtp_timestamp(),
            sender_wall_ns: (ntp != 0).then_some(ntp_ns),
            arrival,
            wall_ns: unix_ns + UNIX_EPOCH_SINCE_1900_NS,
        }
    })
}

impl Connection<'_> {
    async fn next(&mut self, until: Instant) -> ConnectionEvent {
        match self {
            Self::Connecting(attempt) => match timeout_at(until, attempt.as_mut()).await {
                Err(_) => ConnectionEvent::Timeout,
                Ok(Ok((session, relay))) => ConnectionEvent::Connected(Box::new(session), relay),
                Ok(Err(error)) => ConnectionEvent::Broken(error),
            },
            Self::Up(session, relay) => match timeout_at(until, session.next()).await {
                Err(_) => ConnectionEvent::Timeout,
                Ok(Some(Ok(item))) => ConnectionEvent::Item(item),
                Ok(Some(Err(error))) => {
                    let reason = relay.reason().unwrap_or_else(|| error.to_string());
                    ConnectionEvent::Broken(ConnectError::Temporary(reason))
                }
                Ok(None) => {
                    let reason = relay.reason().unwrap_or_else(|| Loss::Broken.to_string());
                    ConnectionEvent::Broken(ConnectError::Temporary(reason))
                }
            },
        }
    }
}

/// Connects through a relay that bounds what the server sends, and that keeps a password from being sent in clear.
async fn connect(
    address: &Url,
    login: Option<&Login>,
    shown_address: &str,
) -> Result<(Demuxed, RelayEnd), ConnectError> {
    let permits_basic = login.is_some_and(|login| login.permits_basic);
    let relay = rtsp_relay::start(address, permits_basic).await;
    let (address, end) = relay.map_err(|error| ConnectError::Temporary(error.to_string()))?;
    match describe_and_play(address, login, shown_address).await {
        Ok(session) => Ok((session, end)),
        Err(error) => Err(match (end.refusal(), end.reason(), error) {
            (Some(Refusal::BasicInClear), ..) => permanent(
                shown_address,
                "takes a password in clear text only (Basic, without TLS), and everybody on the network could read it",
                "Set the camera to Digest, or use its rtsps:// address; on a network that you trust, \
                 video.allow_basic_login = true in the configuration sends it in clear",
            ),
            (_, _, ConnectError::Permanent(error)) => ConnectError::Permanent(error),
            (_, Some(reason), ConnectError::Temporary(_)) => ConnectError::Temporary(reason),
            (_, None, error) => error,
        }),
    }
}

async fn describe_and_play(
    address: Url,
    login: Option<&Login>,
    shown_address: &str,
) -> Result<Demuxed, ConnectError> {
    let credentials =
        login.map(|login| Credentials { username: login.user.clone(), password: login.password.clone() });
    let options = SessionOptions::default().creds(credentials).user_agent("barrelman".to_owned());
    let connect_error = |error: retina::Error| match error.status_code() {
        Some(401 | 403) => permanent(
            shown_address,
            "does not let us in",
            "Write USER:PASSWORD on the first line of a file and give --video-login-file FILE, or name the file as \
             video.login_file in the configuration",
        ),
        Some(300..=399) => permanent(
            shown_address,
            "leads to another address (an RTSP redirect), and no redirect is followed",
            "Give the address of the stream itself with --video",
        ),
        _ => ConnectError::Temporary(error.to_string()),
    };
    let mut session = Session::describe(address, options).await.map_err(connect_error)?;
    let is_video = |stream: &&retina::client::Stream| stream.media() == "video";
    let is_h264 =
        |stream: &retina::client::Stream| stream.media() == "video" && stream.encoding_name() == "h264";
    let Some(stream) = session.streams().iter().position(is_h264) else {
        let found =
            session.streams().iter().find(is_video).map(|stream| stream.encoding_name().to_uppercase());
        let what = found
            .map_or("offers no video".to_owned(), |codec| format!("sends {codec}, and only H.264 is read"));
        return Err(permanent(shown_address, &what, "Set the camera, or this profile of it, to H.264"));
    };
    let transport = Transport::Tcp(TcpTransportOptions::default());
    let setup = SetupOptions::default().transport(transport).frame_format(FrameFormat::SIMPLE);
    session.setup(stream, setup).await.map_err(connect_error)?;
    let playing = session.play(PlayOptions::default()).await.map_err(connect_error)?;
    playing.demuxed().map_err(connect_error)
}

fn permanent(shown_address: &str, what: &str, remedy: &str) -> ConnectError {
    ConnectError::Permanent(VideoError::Stream {
        address: shown_address.to_owned(),
        what: what.to_owned(),
        remedy: remedy.to_owned(),
    })
}
