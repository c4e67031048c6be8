//! The built-in engine for live streams: H.264 over RTSP (RFC 2326), interleaved in the TCP connection, so
//! that no packet is lost or out of order.
//!
//! Each connection has an asynchronous runtime of its own, which ends with the connection and leaves no task
//! behind. Not handled: RTP over UDP, TLS, other codecs, several video streams in one session (the first
//! H.264 stream is used).

use std::pin::Pin;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_media_protocol::failure::{SourceFailure, from_status};
use barrelman_vocab::unit::{Rotation, UnitCodec};
use bytes::Bytes;
use futures_util::StreamExt;
use retina::client::{
    Credentials, Demuxed, PlayOptions, Session, SessionOptions, SetupOptions, TcpTransportOptions, Transport,
};
use retina::codec::{CodecItem, FrameFormat, ParametersRef};
use retina::rtcp::ReceivedCompoundPacket;
use tokio::runtime::{Builder, Runtime};
use tokio::time::timeout_at;
use url::Url;

use super::receiver::{Broken, Connection, ConnectionEvent, Engine, ReceivedTime, ReceivedUnit};
use super::rtsp_filter::Refusal;
use super::rtsp_relay::{self, RelayEnd};
use super::sender_clock::SenderReport;
use super::supervision::{CONNECT_TIMEOUT, Loss};
use super::url::Login;
use super::wall_time::{sender_wall_ns, since_1900_ns};
use crate::codec::annexb::AvcConfiguration;
use crate::error::VideoError;

/// Time for the session to send its TEARDOWN to the server.
const TEARDOWN_TIMEOUT: Duration = Duration::from_millis(100);

/// The built-in engine for one address.
pub(super) struct RtspEngine {
    /// The address, without user and password.
    pub(super) address: Url,
    pub(super) login: Option<Login>,
    /// The address for messages.
    pub(super) shown_address: String,
    pub(super) clock: Clock,
}

impl Engine for RtspEngine {
    const CONNECT_TIMEOUT: Duration = CONNECT_TIMEOUT;

    fn connect(&mut self) -> Result<impl Connection, VideoError> {
        let runtime = Builder::new_current_thread().enable_all().build().map_err(VideoError::Thread)?;
        let attempt = Box::pin(connect(self.address.clone(), self.login.clone(), self.shown_address.clone()));
        Ok(RtspConnection {
            phase: Some(Phase::Connecting(attempt)),
            runtime: Some(runtime),
            clock: self.clock,
            units: 0,
        })
    }
}

type Attempt = Pin<Box<dyn Future<Output = Result<(Demuxed, RelayEnd), Broken>>>>;

/// A connection with an asynchronous runtime of its own, which leaves no task behind.
struct RtspConnection {
    /// `None` only while the connection is dropped.
    phase: Option<Phase>,
    runtime: Option<Runtime>,
    clock: Clock,
    units: u64,
}

enum Phase {
    Connecting(Attempt),
    Up(Box<Demuxed>, RelayEnd),
}

impl Connection for RtspConnection {
    fn next(&mut self, until: Instant) -> ConnectionEvent {
        let (Some(runtime), Some(phase)) = (&self.runtime, &mut self.phase) else {
            return ConnectionEvent::Timeout;
        };
        let until = until.into();
        match phase {
            Phase::Connecting(attempt) => {
                match runtime.block_on(async { timeout_at(until, attempt.as_mut()).await }) {
                    Err(_) => ConnectionEvent::Timeout,
                    Ok(Ok((session, relay))) => {
                        self.phase = Some(Phase::Up(Box::new(session), relay));
                        ConnectionEvent::Connected
                    }
                    Ok(Err(broken)) => ConnectionEvent::Broken(broken),
                }
            }
            Phase::Up(session, relay) => {
                let broken = |reason: String| {
                    let (reason, is_reached) = (relay.reason().unwrap_or(reason), true);
                    ConnectionEvent::Broken(Broken::Temporary { reason, is_reached })
                };
                match runtime.block_on(async { timeout_at(until, session.next()).await }) {
                    Err(_) => ConnectionEvent::Timeout,
                    Ok(Some(Ok(item))) => self.event(item),
                    Ok(Some(Err(error))) if relay.reason().is_none() && !is_io(&error) => {
                        ConnectionEvent::Broken(Broken::Misread(first_line(&error)))
                    }
                    Ok(Some(Err(error))) => broken(first_line(&error)),
                    Ok(None) => broken(Loss::Broken.to_string()),
                }
            }
        }
    }
}

impl RtspConnection {
    fn event(&mut self, item: CodecItem) -> ConnectionEvent {
        match item {
            CodecItem::VideoFrame(video) => {
                // The sender's RTP time is in the low 32 bits.
                let time = ReceivedTime::Ticks(video.timestamp().timestamp() as u32);
                // The arrival of the first packet of a picture is nearest to its capture.
                let arrival = self.clock.at(video.start_ctx().received());
                let key = video.is_random_access_point();
                let mut payload = video.into_data();
                // A stream without key pictures may name its parameters in the description alone.
                if self.units == 0 && !key {
                    payload = [self.described_parameters(), payload].concat();
                }
                self.units += 1;
                ConnectionEvent::Unit(ReceivedUnit {
                    codec: UnitCodec::H264AnnexB,
                    key,
                    follows_loss: false,
                    rotation: Rotation::None,
                    time,
                    arrival,
                    payload: Bytes::from(payload),
                })
            }
            CodecItem::Rtcp(report) => {
                ConnectionEvent::Reports(sender_reports(&report, self.clock).collect())
            }
            _ => ConnectionEvent::Timeout,
        }
    }

    /// The parameter sets of the stream's description, Annex B.
    fn described_parameters(&self) -> Vec<u8> {
        let Some(Phase::Up(session, _)) = &self.phase else { return Vec::new() };
        let parameters = session.streams().iter().find_map(|stream| match stream.parameters() {
            Some(ParametersRef::Video(parameters)) => AvcConfiguration::parse(parameters.extra_data()),
            _ => None,
        });
        parameters.map_or_else(Vec::new, |parameters| parameters.parameter_sets)
    }
}

impl Drop for RtspConnection {
    /// Lets the session send its TEARDOWN, then ends its tasks.
    fn drop(&mut self) {
        let Some(runtime) = self.runtime.take() else { return };
        runtime.block_on(async {
            self.phase = None;
            tokio::time::sleep(TEARDOWN_TIMEOUT).await;
        });
        runtime.shutdown_background();
    }
}

/// The sender reports of a packet.
fn sender_reports(packet: &ReceivedCompoundPacket, clock: Clock) -> impl Iterator<Item = SenderReport> {
    let received = packet.ctx().received();
    let arrival = clock.at(received);
    let wall_ns = since_1900_ns(received.elapsed());
    packet.pkts().filter_map(|packet| packet.as_sender_report().ok().flatten()).map(move |report| {
        let sender_wall_ns = sender_wall_ns(report.ntp_timestamp().0);
        SenderReport { rtp: report.rtp_timestamp(), sender_wall_ns, arrival, wall_ns }
    })
}

/// Connects through a relay that bounds what the server sends, and that keeps a password from being sent in
/// clear.
async fn connect(
    address: Url,
    login: Option<Login>,
    shown_address: String,
) -> Result<(Demuxed, RelayEnd), Broken> {
    let permits_basic = login.as_ref().is_some_and(|login| login.permits_basic);
    let relay = rtsp_relay::start(&address, permits_basic).await;
    let (address, end) =
        relay.map_err(|error| Broken::Temporary { reason: error.to_string(), is_reached: false })?;
    match describe_and_play(address, login, &shown_address).await {
        Ok(session) => Ok((session, end)),
        Err(error) => Err(match (end.refusal(), end.reason(), error) {
            (Some(Refusal::BasicInClear), ..) => refused(
                &shown_address,
                "takes a password in clear text only (Basic, without TLS), and everybody on the network could read it",
                "Set the camera to Digest, or use its rtsps:// address; on a network that you trust, \
                 video.allow_basic_login = true in the configuration sends it in clear",
            ),
            (_, Some(reason), Broken::Temporary { .. }) => {
                Broken::Temporary { reason, is_reached: end.is_reached() }
            }
            (_, _, broken) => broken,
        }),
    }
}

async fn describe_and_play(
    address: Url,
    login: Option<Login>,
    shown_address: &str,
) -> Result<Demuxed, Broken> {
    let credentials = login.map(|login| Credentials { username: login.user, password: login.password });
    let options = SessionOptions::default().creds(credentials).user_agent("barrelman".to_owned());
    let connect_error = |error: retina::Error| broken_by(&error, shown_address);
    let mut session = Session::describe(address, options).await.map_err(connect_error)?;
    let is_video = |stream: &&retina::client::Stream| stream.media() == "video";
    let is_h264 =
        |stream: &retina::client::Stream| stream.media() == "video" && stream.encoding_name() == "h264";
    let Some(stream) = session.streams().iter().position(is_h264) else {
        let found =
            session.streams().iter().find(is_video).map(|stream| stream.encoding_name().to_uppercase());
        let what = found
            .map_or("offers no video".to_owned(), |codec| format!("sends {codec}, and only H.264 is read"));
        let remedy = "Set the camera, or this profile of it, to H.264";
        return Err(Broken::Unsupported(unusable(shown_address, &what, remedy)));
    };
    let transport = Transport::Tcp(TcpTransportOptions::default());
    let setup = SetupOptions::default().transport(transport).frame_format(FrameFormat::SIMPLE);
    session.setup(stream, setup).await.map_err(connect_error)?;
    let playing = session.play(PlayOptions::default()).await.map_err(connect_error)?;
    playing.demuxed().map_err(connect_error)
}

/// What the library's error means.
fn broken_by(error: &retina::Error, shown_address: &str) -> Broken {
    let known = error.status_code().and_then(|status| Some((status, from_status(status)?)));
    let Some((status, failure)) = known else {
        return Broken::Temporary { reason: first_line(error), is_reached: true };
    };
    let SourceFailure { what, remedy, .. } = failure;
    match status {
        401 | 403 | 407 => refused(shown_address, &what, &remedy),
        // Another engine may take what this one does not.
        300..=399 | 406 | 415 | 461 => Broken::Unsupported(unusable(shown_address, &what, &remedy)),
        _ => {
            // A server that knows the stream later, or has room later, answers another engine alike.
            let is_reached = !matches!(status, 404 | 410 | 453 | 503);
            Broken::Temporary { reason: format!("it {what} ({status}): {remedy}"), is_reached }
        }
    }
}

/// The library's error without the lines that describe the connection.
fn first_line(error: &retina::Error) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default().trim_end_matches(['{', ' ']);
    line.to_owned()
}

/// Whether the connection was cut, where other errors are messages that the library does not take.
fn is_io(error: &retina::Error) -> bool {
    let text = error.to_string();
    ["Error reading from RTSP peer", "Error writing to RTSP peer"].iter().any(|io| text.starts_with(io))
}

fn refused(shown_address: &str, what: &str, remedy: &str) -> Broken {
    Broken::Refused(unusable(shown_address, what, remedy))
}

fn unusable(shown_address: &str, what: &str, remedy: &str) -> VideoError {
    VideoError::Stream { address: shown_address.to_owned(), what: what.to_owned(), remedy: remedy.to_owned() }
}
