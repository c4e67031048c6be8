//! A small RTSP server for the video of a simulated world (RFC 2326; H.264 in RTP by RFC 6184).
//!
//! | thread | does |
//! |---|---|
//! | `rtsp` | accepts connections, at most [`MAX_VIEWERS`] at a time |
//! | `rtsp-viewer` | answers one viewer's requests, and sends the video |
//!
//! The video is interleaved into the RTSP connection, from the next key frame on. A viewer that is too slow
//! misses pictures up to the next key frame; a viewer that requests nothing for [`CLIENT_TIMEOUT`] before it
//! plays is disconnected. Not handled: UDP, authentication, seeking, RTCP. The server is meant for loopback.

use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{EncodedUnit, VideoFrame};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;

use barrelman_video::annexb::{self, NalKind};
use barrelman_video::{VideoSink, VideoState};

use super::rtp_packetiser::{RTP_HZ, RTP_TYPE, RtpPacketiser};

/// How many viewers the server has at a time.
const MAX_VIEWERS: usize = 4;
/// Longest request, bytes.
const MAX_REQUEST_BYTES: usize = 4096;
/// Capacity of a viewer's queue of pictures.
const QUEUE: usize = 32;
/// How long a viewer waits for the first picture, how long a write to a viewer may block, and how long a
/// viewer that does not play may be silent.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval at which a viewer's requests are read.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// A running server. Dropping it ends the server.
pub struct RtspServer {
    address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    client_timeout: Duration,
    viewers: Mutex<Vec<SyncSender<EncodedUnit>>>,
    /// SPS and PPS of the newest key frame.
    parameter_sets: Mutex<Option<(Vec<u8>, Vec<u8>)>>,
    connections: Mutex<usize>,
    is_wanted: AtomicBool,
    is_ended: AtomicBool,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Plain data: a panic of another thread leaves no broken state.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl RtspServer {
    /// Starts the server on a thread of its own.
    ///
    /// # Errors
    /// If the address cannot be used, or the system has no more threads.
    pub fn start(address: SocketAddr) -> Result<Self> {
        Self::start_with(address, CLIENT_TIMEOUT)
    }

    fn start_with(address: SocketAddr, client_timeout: Duration) -> Result<Self> {
        let listener =
            TcpListener::bind(address).with_context(|| format!("cannot serve video at {address}"))?;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let shared = Arc::new(Shared { client_timeout, ..Shared::default() });
        let of_thread = Arc::clone(&shared);
        let thread = Builder::new().name("rtsp".to_owned()).spawn(move || accept(&listener, &of_thread))?;
        Ok(Self { address, shared, thread: Some(thread) })
    }

    /// The URL of the video.
    pub fn url(&self) -> String {
        format!("rtsp://{}/world", self.address)
    }

    /// Whether a viewer has requested the video yet.
    pub fn is_wanted(&self) -> bool {
        self.shared.is_wanted.load(Ordering::Relaxed)
    }

    /// A sink for the video to serve.
    pub fn sink(&self) -> impl VideoSink + 'static {
        Broadcast(Arc::clone(&self.shared))
    }
}

impl Drop for RtspServer {
    fn drop(&mut self) {
        self.shared.is_ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Broadcast(Arc<Shared>);

impl VideoSink for Broadcast {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        if unit.codec != UnitCodec::H264AnnexB {
            return;
        }
        if unit.key {
            let first =
                |kind| annexb::nals(&unit.payload).find(|nal| annexb::kind(nal) == kind).map(<[u8]>::to_vec);
            if let (Some(sps), Some(pps)) = (first(NalKind::Sps), first(NalKind::Pps)) {
                *locked(&self.0.parameter_sets) = Some((sps, pps));
            }
        }
        locked(&self.0.viewers)
            .retain(|viewer| !matches!(viewer.try_send(unit.clone()), Err(TrySendError::Disconnected(_))));
    }

    fn on_frame(&mut self, _frame: VideoFrame) {}

    fn on_state(&mut self, state: VideoState) {
        match state {
            VideoState::Ended => self.0.is_ended.store(true, Ordering::Relaxed),
            VideoState::Failed(error) => {
                tracing::error!("{error}");
                self.0.is_ended.store(true, Ordering::Relaxed);
            }
            VideoState::Connecting | VideoState::Up | VideoState::Lost { .. } => {}
        }
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.is_ended.load(Ordering::Relaxed) {
        let Ok((stream, _)) = listener.accept() else {
            std::thread::sleep(POLL_INTERVAL);
            continue;
        };
        let Some(slot) = ViewerSlot::take(shared) else { continue };
        // Without a further thread, the viewer is disconnected, and the slot is free again.
        let _ = Builder::new().name("rtsp-viewer".to_owned()).spawn(move || {
            // A viewer that hangs up is not an error.
            let _ = Viewer::new(stream, Arc::clone(&slot.0)).and_then(Viewer::serve);
        });
    }
}

/// One of the [`MAX_VIEWERS`] viewers. Dropping it, also by a panic, makes room for another viewer.
struct ViewerSlot(Arc<Shared>);

impl ViewerSlot {
    fn take(shared: &Arc<Shared>) -> Option<Self> {
        let mut connections = locked(&shared.connections);
        if *connections >= MAX_VIEWERS {
            return None;
        }
        *connections += 1;
        Some(Self(Arc::clone(shared)))
    }
}

impl Drop for ViewerSlot {
    fn drop(&mut self) {
        *locked(&self.0.connections) -= 1;
    }
}

struct Viewer {
    stream: TcpStream,
    shared: Arc<Shared>,
    received: Vec<u8>,
    units: Option<Receiver<EncodedUnit>>,
    channel: u8,
    packetiser: RtpPacketiser,
    /// Whether pictures are dropped until the next key frame.
    waits_for_key: bool,
    last_index: Option<u64>,
}

impl Viewer {
    fn new(stream: TcpStream, shared: Arc<Shared>) -> io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(CLIENT_TIMEOUT))?;
        stream.set_read_timeout(Some(POLL_INTERVAL))?;
        Ok(Self {
            stream,
            shared,
            received: Vec::new(),
            units: None,
            channel: 0,
            packetiser: RtpPacketiser::default(),
            waits_for_key: true,
            last_index: None,
        })
    }

    fn serve(mut self) -> io::Result<()> {
        let mut buffer = [0; 1024];
        let mut heard = Instant::now();
        while !self.shared.is_ended.load(Ordering::Relaxed) {
            match self.stream.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(read) => self.received.extend_from_slice(&buffer[..read]),
                Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                }
                Err(error) => return Err(error),
            }
            while let Some(request) = next_request(&mut self.received)? {
                heard = Instant::now();
                if !self.answer(&request)? {
                    return Ok(());
                }
            }
            if self.units.is_some() {
                self.play()?;
            } else if heard.elapsed() > self.shared.client_timeout {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Sends the next picture to a viewer that plays. Reads no longer wait, because waiting for the video
    /// does.
    fn play(&mut self) -> io::Result<()> {
        self.stream.set_read_timeout(Some(Duration::from_millis(1)))?;
        let Some(units) = &self.units else { return Ok(()) };
        let Ok(unit) = units.recv_timeout(POLL_INTERVAL) else { return Ok(()) };
        let is_next = self.last_index.is_some_and(|last| unit.index == last + 1);
        self.last_index = Some(unit.index);
        self.waits_for_key = !unit.key && (self.waits_for_key || !is_next);
        if self.waits_for_key {
            return Ok(());
        }
        let bytes = self.packetiser.packets(&unit, self.channel);
        self.stream.write_all(&bytes)
    }

    /// Answers a request. Returns `false` after the last one.
    fn answer(&mut self, request: &str) -> io::Result<bool> {
        let mut lines = request.lines();
        let mut words = lines.next().unwrap_or_default().split(' ');
        let (method, url) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let field = |name: &str| {
            lines.clone().find_map(|line| {
                let (key, value) = line.split_once(':')?;
                key.eq_ignore_ascii_case(name).then(|| value.trim())
            })
        };
        let sequence: u32 = field("CSeq").and_then(|text| text.parse().ok()).unwrap_or(0);
        let answer = |status: &str, fields: &str, body: &str| {
            let length =
                if body.is_empty() { String::new() } else { format!("Content-Length: {}\r\n", body.len()) };
            format!("RTSP/1.0 {status}\r\nCSeq: {sequence}\r\n{fields}{length}\r\n{body}")
        };
        const SESSION: &str = "Session: 1\r\n";
        let text = match method {
            "OPTIONS" => {
                answer("200 OK", "Public: OPTIONS, DESCRIBE, SETUP, PLAY, GET_PARAMETER, TEARDOWN\r\n", "")
            }
            "DESCRIBE" => {
                self.shared.is_wanted.store(true, Ordering::Relaxed);
                match self.session_description() {
                    Some(body) => {
                        let base = format!("{}/", url.trim_end_matches('/'));
                        let fields = format!("Content-Base: {base}\r\nContent-Type: application/sdp\r\n");
                        answer("200 OK", &fields, &body)
                    }
                    None => answer("503 Service Unavailable", "", ""),
                }
            }
            "SETUP" => match field("Transport").and_then(interleaved_channel) {
                Some(channel) => {
                    self.channel = channel;
                    let transport = format!(
                        "Transport: RTP/AVP/TCP;unicast;interleaved={channel}-{}\r\n{SESSION}",
                        channel.wrapping_add(1)
                    );
                    answer("200 OK", &transport, "")
                }
                None => answer("461 Unsupported Transport", "", ""),
            },
            "PLAY" => {
                let (viewer, units) = sync_channel(QUEUE);
                locked(&self.shared.viewers).push(viewer);
                self.units = Some(units);
                answer("200 OK", SESSION, "")
            }
            "GET_PARAMETER" => answer("200 OK", SESSION, ""),
            "TEARDOWN" => answer("200 OK", SESSION, ""),
            _ => answer("501 Not Implemented", "", ""),
        };
        self.stream.write_all(text.as_bytes())?;
        Ok(method != "TEARDOWN")
    }

    /// The session description (SDP). Waits for the first key frame; `None` where none comes in time.
    fn session_description(&self) -> Option<String> {
        let deadline = Instant::now() + self.shared.client_timeout;
        let (sps, pps) = loop {
            if let Some(sets) = locked(&self.shared.parameter_sets).clone() {
                break sets;
            }
            if Instant::now() >= deadline || self.shared.is_ended.load(Ordering::Relaxed) {
                return None;
            }
            std::thread::sleep(POLL_INTERVAL);
        };
        let profile = sps.get(1..4)?.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        Some(format!(
            "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=Barrelman\r\nc=IN IP4 0.0.0.0\r\nt=0 0\r\na=control:*\r\n\
             m=video 0 RTP/AVP {RTP_TYPE}\r\na=rtpmap:{RTP_TYPE} H264/{RTP_HZ}\r\n\
             a=fmtp:{RTP_TYPE} packetization-mode=1;profile-level-id={profile};sprop-parameter-sets={},{}\r\n\
             a=control:video\r\n",
            BASE64_STANDARD.encode(&sps),
            BASE64_STANDARD.encode(&pps),
        ))
    }
}

/// Removes a complete request from the front of the received bytes. RTCP packets between requests are
/// skipped.
fn next_request(received: &mut Vec<u8>) -> io::Result<Option<String>> {
    loop {
        if received.first() == Some(&b'$') {
            let Some(length) =
                received.get(2..4).map(|length| 4 + usize::from(length[0]) * 256 + usize::from(length[1]))
            else {
                return Ok(None);
            };
            if received.len() < length {
                return Ok(None);
            }
            received.drain(..length);
            continue;
        }
        let Some(end) = received.windows(4).position(|four| four == b"\r\n\r\n") else {
            if received.len() > MAX_REQUEST_BYTES {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "the request is too long"));
            }
            return Ok(None);
        };
        let request: Vec<u8> = received.drain(..end + 4).collect();
        return Ok(Some(String::from_utf8_lossy(&request).into_owned()));
    }
}

/// The RTP channel of an interleaved transport; `None` where only other transports are offered.
fn interleaved_channel(transport: &str) -> Option<u8> {
    let interleaved = transport.split(',').find(|offer| offer.contains("RTP/AVP/TCP"))?;
    let channels = interleaved.split(';').find_map(|part| part.trim().strip_prefix("interleaved="));
    channels.map_or(Some(0), |channels| channels.split('-').next()?.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silent_viewers_make_room_for_one_that_speaks() {
        let server = RtspServer::start_with(([127, 0, 0, 1], 0).into(), Duration::from_millis(300)).unwrap();
        let connect = || TcpStream::connect(server.address).unwrap();
        let silent: Vec<TcpStream> = (0..MAX_VIEWERS).map(|_| connect()).collect();
        for mut viewer in silent {
            assert_eq!(viewer.read(&mut [0; 16]).unwrap(), 0, "disconnected");
        }
        let mut speaking = connect();
        speaking.write_all(b"OPTIONS * RTSP/1.0\r\nCSeq: 7\r\n\r\n").unwrap();
        let mut answer = [0; 15];
        speaking.read_exact(&mut answer).unwrap();
        assert_eq!(&answer, b"RTSP/1.0 200 OK");
    }

    #[test]
    fn a_panic_of_a_viewer_frees_its_slot() {
        let shared = Arc::new(Shared::default());
        let slots: Vec<_> = (0..MAX_VIEWERS).map_while(|_| ViewerSlot::take(&shared)).collect();
        assert!(slots.len() == MAX_VIEWERS && ViewerSlot::take(&shared).is_none());
        let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || {
            let _slots = slots;
            panic!("of a viewer");
        }));
        assert!(panicked.is_err() && ViewerSlot::take(&shared).is_some());
    }

    #[test]
    fn requests_are_read_one_by_one_and_rtcp_is_skipped() {
        let mut received = b"$\x01\x00\x02abOPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\nPLAY".to_vec();
        assert_eq!(next_request(&mut received).unwrap().unwrap(), "OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n");
        assert_eq!(next_request(&mut received).unwrap(), None);
        received.resize(MAX_REQUEST_BYTES + 1, b'x');
        assert!(next_request(&mut received).is_err());
    }

    #[test]
    fn only_an_interleaved_transport_is_accepted() {
        assert_eq!(interleaved_channel("RTP/AVP/TCP;unicast;interleaved=2-3"), Some(2));
        assert_eq!(interleaved_channel("RTP/AVP/TCP;unicast"), Some(0));
        assert_eq!(interleaved_channel("RTP/AVP;unicast;client_port=5000-5001"), None);
    }
}
