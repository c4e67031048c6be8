//! A stream over RTSP: a server on the loopback answers as a camera does, and sends any bytes as the stream.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_video::{DecodeError, VideoSink, VideoState, VideoUrl, live};
use barrelman_vocab::VideoFrame;
use barrelman_vocab::unit::EncodedUnit;

/// Longest wait for the end of a stream: longer than the receiver waits for a connection.
const PATIENCE: Duration = Duration::from_secs(10);

const DESCRIPTION: &str = "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\n\
     a=rtpmap:96 H264/90000\r\na=fmtp:96 packetization-mode=1\r\na=control:track1\r\n";

/// Receives any bytes as a stream: RTP packets, one for each 64 bytes, behind the heads that they need; where
/// the first byte is odd, as they are. The receiver says that the stream has ended, and no thread of it
/// panics.
pub fn receive(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    let stream = if first & 1 == 1 { rest.to_vec() } else { packets(rest) };
    let listener = TcpListener::bind("127.0.0.1:0").expect("the loopback has a free port");
    let address = listener.local_addr().expect("a listener has an address");
    let server = std::thread::spawn(move || {
        if let Ok((client, _)) = listener.accept() {
            serve(client, &stream);
        }
    });
    let (ended, is_ended) = channel();
    let url = VideoUrl::parse(&format!("rtsp://{address}/stream")).expect("the address is usable");
    let source = live::spawn(url, Clock::start(), Sink(ended)).expect("there is room for a thread");
    let heard = is_ended.recv_timeout(PATIENCE);
    source.stop().expect("the receiver ends");
    server.join().expect("the server does not panic");
    heard.expect("the receiver says that the stream has ended");
}

/// Packets of RTP, interleaved in the connection (RFC 2326, 10.12). The first byte of each names what is
/// wrong with its head.
fn packets(bytes: &[u8]) -> Vec<u8> {
    let mut stream = Vec::new();
    for (number, part) in (0_u16..).zip(bytes.chunks(64)) {
        let Some((&flaw, payload)) = part.split_first() else { continue };
        let sequence = if flaw & 4 == 4 { number.wrapping_mul(7) } else { number };
        let jump = if flaw & 8 == 8 { 0x8000_0000 } else { 0 };
        let ticks = (u32::from(number / 3) * 3_000) ^ jump;
        let mut packet = vec![0x80, if flaw & 1 == 1 { 0xe0 } else { 0x60 }];
        packet.extend_from_slice(&sequence.to_be_bytes());
        packet.extend_from_slice(&ticks.to_be_bytes());
        packet.extend_from_slice(&7_u32.to_be_bytes());
        packet.extend_from_slice(payload);
        let channel = if flaw & 0x30 == 0x30 { 1 } else { 0 };
        stream.extend_from_slice(&[b'$', channel]);
        stream.extend_from_slice(&(packet.len() as u16).to_be_bytes());
        stream.extend_from_slice(&packet);
    }
    stream
}

/// Answers the requests of a client up to PLAY, sends the stream, and closes the connection.
fn serve(mut client: TcpStream, stream: &[u8]) {
    let _ = client.set_read_timeout(Some(PATIENCE));
    let mut received = Vec::new();
    let mut buffer = [0; 2048];
    loop {
        let Some(end) = received.windows(4).position(|window| window == b"\r\n\r\n") else {
            match client.read(&mut buffer) {
                Ok(read) if read > 0 => received.extend_from_slice(&buffer[..read]),
                _ => return,
            }
            continue;
        };
        let request: Vec<u8> = received.drain(..end + 4).collect();
        let request = String::from_utf8_lossy(&request).into_owned();
        let number = request
            .lines()
            .find_map(|line| line.to_ascii_lowercase().strip_prefix("cseq:").map(|n| n.trim().to_owned()))
            .unwrap_or_default();
        let head = format!("RTSP/1.0 200 OK\r\nCSeq: {number}\r\n");
        let method = request.split(' ').next().unwrap_or_default();
        let answer = match method {
            "DESCRIBE" => format!(
                "{head}Content-Type: application/sdp\r\nContent-Length: {}\r\n\r\n{DESCRIPTION}",
                DESCRIPTION.len()
            ),
            "SETUP" => format!("{head}Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n\r\n"),
            "PLAY" => format!("{head}Session: 1\r\nRTP-Info: url=track1;seq=0;rtptime=0\r\n\r\n"),
            _ => format!("{head}Public: DESCRIBE, SETUP, PLAY, TEARDOWN\r\n\r\n"),
        };
        if client.write_all(answer.as_bytes()).is_err() {
            return;
        }
        if method == "PLAY" {
            let _ = client.write_all(stream);
            return;
        }
    }
}

/// Tells when the stream has ended.
struct Sink(Sender<()>);

impl VideoSink for Sink {
    fn on_unit(&mut self, _unit: &EncodedUnit) {}

    fn on_frame(&mut self, frame: VideoFrame) {
        assert!(frame.picture.size().width > 0);
    }

    fn on_state(&mut self, state: VideoState) {
        if !matches!(state, VideoState::Connecting | VideoState::Up) {
            // The receiver reconnects; the first end is enough.
            let _ = self.0.send(());
        }
    }

    fn on_damage(&mut self, _error: &DecodeError) {}
}
