//! RTSP servers: one that plays, and some that refuse.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{
    FromSource, RtspTransport, SourceAddress, SourceLogin, SourceSettings, UnitTime,
};

use crate::clip::Unit;
use crate::media::Media;

/// A server that plays a test picture.
struct Server {
    child: Child,
    url: String,
}

impl Server {
    /// `None`: GStreamer's server is not installed.
    fn start(codec: &str) -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/rtsp_server.py");
        let python = || {
            let mut python = Command::new("/usr/bin/python3");
            python.arg(&script);
            python
        };
        let is_there = python().arg("--check").output().is_ok_and(|done| done.status.success());
        assert!(is_there || std::env::var_os("CI").is_none(), "GStreamer's RTSP server is not installed");
        if !is_there {
            eprintln!("skipped: GStreamer's RTSP server is not installed (scripts/setup.sh test)");
            return None;
        }
        let mut child = python()
            .args(["--port", "0", "--pattern", "ball", "--size", "320x240", "--codec", codec])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        Some(Self { child, url: url.trim().to_owned() })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn start(url: &str, transport: RtspTransport, login: Option<SourceLogin>) -> Media {
    let address = SourceAddress::Rtsp { url: url.to_owned(), transport, login };
    Media::start(Role::Source(SourceSettings { address, is_live: true }))
}

fn check(codec: &str, format: CodedFormat, transport: RtspTransport, opened: &str) {
    let Some(server) = Server::start(codec) else { return };
    let mut media = start(&server.url, transport, None);
    let (mut units, mut times, mut was_opened) = (Vec::new(), Vec::new(), None);
    while units.len() < 20 {
        let (message, payload) = media.receive::<FromSource>().unwrap().expect("the source is silent");
        match message {
            FromSource::Opened(text) => was_opened = Some(text),
            FromSource::Unit(unit) => {
                let UnitTime::Ticks(ticks) = unit.time else { panic!("{unit:?}") };
                times.push(ticks);
                units.push(Unit { payload, pts_ns: units.len() as u64, key: unit.key });
            }
            FromSource::Alive | FromSource::SenderReport(_) => {}
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(was_opened.as_deref(), Some(opened));
    assert!(times.windows(2).all(|pair| pair[1].wrapping_sub(pair[0]).abs_diff(3000) < 10), "{times:?}");
    let first = units.iter().position(|unit| unit.key).unwrap();
    let pictures = Media::decoder(format, true).decode_all(&units[first..]);
    assert_eq!(pictures.len(), units.len() - first);
    assert!(media.close().success());
}

#[test]
fn h264_over_tcp() {
    check("h264", CodedFormat::H264, RtspTransport::Auto, "H.264 by RTP over TCP");
}

#[test]
fn h264_over_udp() {
    check("h264", CodedFormat::H264, RtspTransport::Udp, "H.264 by RTP over UDP");
}

#[test]
fn h265_over_tcp() {
    check("h265", CodedFormat::H265, RtspTransport::Tcp, "H.265 by RTP over TCP");
}

#[test]
fn sender_reports_are_passed_on() {
    let Some(server) = Server::start("h264") else { return };
    let mut media = start(&server.url, RtspTransport::Tcp, None);
    let mut newest = None;
    loop {
        match media.receive::<FromSource>().unwrap().unwrap().0 {
            FromSource::Unit(unit) => newest = Some(unit),
            FromSource::SenderReport(report) => {
                // The sender's clock is that of this machine; its time stamps are near those of the newest
                // picture.
                assert!(report.ntp > 0 && report.arrival_ns > 0, "{report:?}");
                if let Some(UnitTime::Ticks(ticks)) = newest.as_ref().map(|unit| unit.time) {
                    let distance = report.rtp.wrapping_sub(ticks).cast_signed().abs();
                    assert!(distance < 10 * 90_000, "{report:?} {ticks}");
                }
                return;
            }
            FromSource::Alive | FromSource::Opened(_) => {}
            other => panic!("{other:?}"),
        }
    }
}

/// A server that answers each request by its method, and what it was sent.
fn fake(
    answer: impl Fn(&str, &str) -> String + Send + 'static,
) -> (String, std::sync::mpsc::Receiver<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("rtsp://{}/live", listener.local_addr().unwrap());
    let (sent, received) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let (mut held, mut byte) = (Vec::new(), [0]);
            while let Ok(1) = stream.read(&mut byte) {
                held.push(byte[0]);
                if held.ends_with(b"\r\n\r\n") {
                    let request = String::from_utf8_lossy(&held).into_owned();
                    held.clear();
                    let method = request.split(' ').next().unwrap_or_default();
                    let line = |line: &&str| line.to_ascii_lowercase().starts_with("cseq:");
                    let cseq = request.lines().find(line).unwrap_or_default();
                    let answer = answer(method, cseq);
                    let _ = sent.send(request);
                    if stream.write_all(answer.as_bytes()).is_err() {
                        break;
                    }
                }
            }
        }
    });
    (url, received)
}

const SDP: &str = "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=x\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\nc=IN IP4 0.0.0.0\r\n\
                   a=rtpmap:96 H264/90000\r\na=control:track1\r\n";

fn described(method: &str, cseq: &str, otherwise: &str) -> String {
    match method {
        "OPTIONS" => format!("RTSP/1.0 200 OK\r\n{cseq}\r\nPublic: DESCRIBE, SETUP, PLAY, TEARDOWN\r\n\r\n"),
        "DESCRIBE" => format!(
            "RTSP/1.0 200 OK\r\n{cseq}\r\nContent-Type: application/sdp\r\nContent-Length: {}\r\n\r\n{SDP}",
            SDP.len()
        ),
        _ => format!("RTSP/1.0 {otherwise}\r\n{cseq}\r\n\r\n"),
    }
}

fn login(permits_basic: bool) -> SourceLogin {
    SourceLogin { user: "captain".to_owned(), password: "secret".to_owned(), permits_basic }
}

fn failure(mut media: Media) -> SourceFailure {
    loop {
        match media.receive::<FromSource>().unwrap().expect("the source is silent").0 {
            FromSource::Failed(failure) => return failure,
            FromSource::Alive => {}
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn refusals_are_told_in_plain_words() {
    let cases = [
        ("401 Unauthorized", "does not let us in", true),
        ("403 Forbidden", "does not let us in", true),
        ("404 Not Found", "has no stream of this name", false),
        ("503 Service Unavailable", "is busy, or has too many viewers", false),
        ("302 Found", "leads to another address (a redirect), which is not followed", true),
    ];
    for (status, what, is_final) in cases {
        let (url, _received) = fake(move |method, cseq| match method {
            "DESCRIBE" => {
                format!("RTSP/1.0 {status}\r\n{cseq}\r\nLocation: rtsp://127.0.0.1:9/other\r\n\r\n")
            }
            _ => described(method, cseq, "200 OK"),
        });
        let failure = failure(start(&url, RtspTransport::Auto, None));
        assert_eq!((failure.what.as_str(), failure.is_final), (what, is_final), "{status}");
        assert!(!failure.remedy.is_empty(), "{status}");
    }
}

#[test]
fn refusals_of_the_stream_itself_are_told_in_plain_words() {
    for (status, what) in [
        ("453 Not Enough Bandwidth", "has not enough bandwidth for one more viewer"),
        ("461 Unsupported Transport", "does not send its packets this way"),
    ] {
        let (url, received) = fake(move |method, cseq| described(method, cseq, status));
        assert_eq!(failure(start(&url, RtspTransport::Auto, None)).what, what);
        let transports: Vec<String> = received
            .try_iter()
            .filter_map(|request| {
                request.lines().find(|line| line.starts_with("Transport:")).map(str::to_owned)
            })
            .collect();
        let asks = |word: &str| transports.iter().any(|transport| transport.contains(word));
        assert!(asks("interleaved"), "{transports:?}");
        // Another way is tried only where the server refuses this one.
        assert_eq!(asks("client_port"), status.starts_with("461"), "{transports:?}");
    }
}

#[test]
fn a_password_is_sent_in_clear_only_where_that_is_permitted() {
    for permits_basic in [false, true] {
        let (url, received) = fake(|method, cseq| match method {
            "DESCRIBE" => {
                format!("RTSP/1.0 401 Unauthorized\r\n{cseq}\r\nWWW-Authenticate: Basic realm=\"x\"\r\n\r\n")
            }
            _ => described(method, cseq, "200 OK"),
        });
        let failure = failure(start(&url, RtspTransport::Tcp, Some(login(permits_basic))));
        let is_sent = received.try_iter().any(|request| request.contains("Authorization: Basic"));
        assert_eq!(is_sent, permits_basic);
        let is_refused = failure.what.contains("in clear text only");
        assert_eq!(is_refused, !permits_basic, "{failure:?}");
        assert!(failure.is_final);
    }
}

#[test]
fn a_digest_is_sent() {
    let (url, received) = fake(|method, cseq| match method {
        "DESCRIBE" => format!(
            "RTSP/1.0 401 Unauthorized\r\n{cseq}\r\nWWW-Authenticate: Digest realm=\"x\", nonce=\"abc\"\r\n\
             WWW-Authenticate: Basic realm=\"x\"\r\n\r\n"
        ),
        _ => described(method, cseq, "200 OK"),
    });
    assert_eq!(failure(start(&url, RtspTransport::Tcp, Some(login(false)))).what, "does not let us in");
    let requests: Vec<String> = received.try_iter().collect();
    assert!(requests.iter().any(|request| request.contains("Authorization: Digest")), "{requests:?}");
    assert!(!requests.iter().any(|request| request.contains("secret") || request.contains("Basic")));
}

#[test]
fn a_server_that_is_absent_is_told() {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let failure = failure(start(&format!("rtsp://{address}/live"), RtspTransport::Auto, None));
    assert_eq!(failure.what, "refuses the connection: nothing listens at this port");
    assert!(!failure.is_final);
}
