//! What passes between `rtspsrc` and a server, in both directions: whole messages within bounds, and no
//! password in clear.

use std::net::SocketAddr;

use barrelman_media_protocol::failure::SourceFailure;
use url::Url;

use super::super::failure::{from_status, permanent, temporary};
use super::announced;

/// The port of RTSP.
pub(super) const RTSP_PORT: u16 = 554;

/// Longest head and longest body of a message, bytes.
const MAX_HEAD: usize = 64 << 10;
const MAX_BODY: usize = 256 << 10;

/// Why the relay ends the connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    /// What comes is no RTSP, or has no bound.
    NotRtsp,
    /// A password would be readable on the network.
    BasicInClear,
    /// The server leads to another server.
    Redirect,
}

impl Refusal {
    pub(super) fn failure(self) -> Option<SourceFailure> {
        match self {
            Self::NotRtsp => Some(temporary(
                "sends what is not RTSP",
                "Check the port in the address: RTSP has 554 unless the camera says otherwise",
            )),
            Self::BasicInClear => Some(permanent(
                "takes a password in clear text only (Basic, without TLS), and everybody on the network could read it",
                "Set the camera to Digest, or use its rtsps:// address; on a network that you trust, \
                 video.allow_basic_login = true in the configuration sends it in clear",
            )),
            Self::Redirect => from_status(302),
        }
    }
}

/// Bytes of one direction, and how many of them are passed on already.
#[derive(Debug, Default)]
struct Held {
    bytes: Vec<u8>,
}

/// A whole message at the beginning of the bytes.
enum Message {
    /// Interleaved data, or line ends between messages.
    Other,
    /// A request or an answer with a head of this length.
    Text(usize),
}

impl Held {
    /// Takes the first message off, if it is whole.
    fn next(&mut self) -> Result<Option<(Message, Vec<u8>)>, Refusal> {
        let (message, length) = match self.bytes[..] {
            [] => return Ok(None),
            [b'\r' | b'\n', ..] => (Message::Other, 1),
            [b'$', _, high, low, ..] => (Message::Other, 4 + usize::from(u16::from_be_bytes([high, low]))),
            [b'$', ..] => return Ok(None),
            _ => {
                let searched = &self.bytes[..self.bytes.len().min(MAX_HEAD)];
                let end = searched.windows(4).position(|window| window == b"\r\n\r\n").map(|at| at + 4);
                let end = end.or_else(|| Some(searched.windows(2).position(|two| two == b"\n\n")? + 2));
                match end {
                    Some(head) => (Message::Text(head), head + body_length(&self.bytes[..head])?),
                    None if searched.len() == MAX_HEAD => return Err(Refusal::NotRtsp),
                    None => return Ok(None),
                }
            }
        };
        if self.bytes.len() < length {
            return Ok(None);
        }
        Ok(Some((message, self.bytes.drain(..length).collect())))
    }
}

/// The values of a header. Names are compared without regard to case.
fn values<'a>(head: &'a [u8], name: &'a str) -> impl Iterator<Item = &'a [u8]> {
    head.split(|byte| *byte == b'\n').filter_map(move |line| {
        let colon = line.iter().position(|byte| *byte == b':')?;
        let is_it = line[..colon].trim_ascii().eq_ignore_ascii_case(name.as_bytes());
        is_it.then(|| line[colon + 1..].trim_ascii())
    })
}

fn body_length(head: &[u8]) -> Result<usize, Refusal> {
    let Some(text) = values(head, "Content-Length").next() else { return Ok(0) };
    let length = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
    length.filter(|length| *length <= MAX_BODY).ok_or(Refusal::NotRtsp)
}

/// The requests of `rtspsrc`.
#[derive(Debug)]
pub(super) struct Requests {
    held: Held,
    permits_basic: bool,
}

impl Requests {
    pub(super) fn new(permits_basic: bool) -> Self {
        Self { held: Held::default(), permits_basic }
    }

    /// Takes bytes and appends the messages that are whole to `out`. Returns the method of the last request.
    pub(super) fn pass(&mut self, bytes: &[u8], out: &mut Vec<u8>) -> Result<Option<String>, Refusal> {
        self.held.bytes.extend_from_slice(bytes);
        let mut method = None;
        while let Some((message, bytes)) = self.held.next()? {
            if let Message::Text(head) = message {
                let head = &bytes[..head];
                let is_basic =
                    |value: &[u8]| value.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"basic"));
                if !self.permits_basic && values(head, "Authorization").any(is_basic) {
                    return Err(Refusal::BasicInClear);
                }
                let word = head.split(|byte| *byte == b' ').next().unwrap_or_default();
                method = Some(String::from_utf8_lossy(word).into_owned());
            }
            out.extend_from_slice(&bytes);
        }
        Ok(method)
    }
}

/// The answers of a server.
#[derive(Debug)]
pub(super) struct Answers {
    held: Held,
    relay: SocketAddr,
    asked: Url,
    sent: Option<&'static str>,
}

impl Answers {
    /// `relay`: where the server is reached. `asked`: the address of the stream. `sent`: the encoding that
    /// the server sends and does not announce.
    pub(super) fn new(relay: SocketAddr, asked: Url, sent: Option<&'static str>) -> Self {
        Self { held: Held::default(), relay, asked, sent }
    }

    /// Takes bytes and appends the messages that are whole to `out`. Returns the status of the last answer.
    pub(super) fn pass(&mut self, bytes: &[u8], out: &mut Vec<u8>) -> Result<Option<u16>, Refusal> {
        self.held.bytes.extend_from_slice(bytes);
        let mut status = None;
        while let Some((message, mut bytes)) = self.held.next()? {
            let Message::Text(head) = message else {
                out.extend_from_slice(&bytes);
                continue;
            };
            let (head, body) = bytes.split_at_mut(head);
            if let Some(sent) = self.sent {
                announced::correct(body, sent);
            }
            let line = String::from_utf8_lossy(head.split(|byte| *byte == b'\n').next().unwrap_or_default());
            if !line.contains("RTSP/") {
                return Err(Refusal::NotRtsp);
            }
            if line.starts_with("RTSP/") {
                status = line.split_whitespace().nth(1).and_then(|number| number.parse().ok());
                let is_redirect = status.is_some_and(|status| (300..400).contains(&status));
                if is_redirect && !self.leads_to_same_server(head) {
                    return Err(Refusal::Redirect);
                }
            }
            put_head(head, self.relay, out);
            out.extend_from_slice(body);
        }
        Ok(status)
    }

    /// Whether a redirect stays with the server that was asked.
    fn leads_to_same_server(&self, head: &[u8]) -> bool {
        let place = |url: &Url| {
            let port = url.port().unwrap_or(RTSP_PORT);
            (url.scheme().to_owned(), url.host_str().map(str::to_ascii_lowercase), port)
        };
        let location = values(head, "Location").next().and_then(|value| std::str::from_utf8(value).ok());
        location.and_then(|to| Url::parse(to).ok()).is_some_and(|to| place(&to) == place(&self.asked))
    }
}

/// Appends a head. The addresses that say where the stream is lead through the relay: a server cannot name
/// another host.
fn put_head(head: &[u8], relay: SocketAddr, out: &mut Vec<u8>) {
    for line in head.split_inclusive(|byte| *byte == b'\n') {
        let place = ["Content-Base", "Content-Location", "Location"].into_iter().find_map(|name| {
            let value = std::str::from_utf8(values(line, name).next()?).ok()?;
            let (_, rest) = value.split_once("://")?;
            Some((name, rest.find(['/', '?']).map_or("", |at| &rest[at..])))
        });
        match place {
            Some((name, path)) => {
                out.extend_from_slice(format!("{name}: rtsp://{relay}{path}\r\n").as_bytes())
            }
            None => out.extend_from_slice(line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers() -> Answers {
        let asked = Url::parse("rtsp://camera.local/live").unwrap();
        Answers::new(SocketAddr::from(([127, 0, 0, 1], 5004)), asked, None)
    }

    #[test]
    fn messages_pass_in_whatever_parts_they_arrive() {
        let text = b"RTSP/1.0 200 OK\r\nCSeq: 1\r\nContent-Length: 5\r\n\r\nv=0\r\n";
        let stream = [&text[..], b"$\x00\x00\x03abc", b"\r\n", text].concat();
        for part in [1, 2, 7, stream.len()] {
            let (mut answers, mut out) = (answers(), Vec::new());
            let statuses: Vec<_> =
                stream.chunks(part).filter_map(|part| answers.pass(part, &mut out).unwrap()).collect();
            assert_eq!(out, stream);
            assert_eq!(statuses.last(), Some(&200));
        }
    }

    #[test]
    fn what_has_no_bound_and_what_is_not_rtsp_is_refused() {
        let cases = [
            vec![b'a'; MAX_HEAD],
            b"RTSP/1.0 200 OK\r\nContent-Length: 262145\r\n\r\n".to_vec(),
            b"RTSP/1.0 200 OK\r\nContent-Length: -1\r\n\r\n".to_vec(),
            b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec(),
        ];
        for bytes in cases {
            assert_eq!(answers().pass(&bytes, &mut Vec::new()), Err(Refusal::NotRtsp));
        }
    }

    #[test]
    fn a_server_cannot_lead_to_another_host() {
        let mut out = Vec::new();
        answers()
            .pass(b"RTSP/1.0 200 OK\r\nContent-Base: rtsp://10.0.0.1:554/live/\r\n\r\n", &mut out)
            .unwrap();
        assert_eq!(out, b"RTSP/1.0 200 OK\r\nContent-Base: rtsp://127.0.0.1:5004/live/\r\n\r\n");
    }

    #[test]
    fn a_redirect_is_followed_on_the_same_server_only() {
        let redirect = |to: &str| format!("RTSP/1.0 302 Found\r\nLocation: {to}\r\n\r\n");
        let elsewhere = [
            "rtsp://10.0.0.1/live",
            "rtsp://camera.local:8554/live",
            "rtsps://camera.local/live",
            "rtsp://camera.local@10.0.0.1/live",
            "http://camera.local/live",
            "/moved",
            "",
        ];
        for to in elsewhere {
            let mut out = Vec::new();
            assert_eq!(answers().pass(redirect(to).as_bytes(), &mut out), Err(Refusal::Redirect), "{to}");
            assert!(out.is_empty());
        }
        for to in ["rtsp://camera.local/moved", "rtsp://camera.local:554/moved", "RTSP://Camera.Local/moved"]
        {
            let mut out = Vec::new();
            assert_eq!(answers().pass(redirect(to).as_bytes(), &mut out), Ok(Some(302)), "{to}");
            assert_eq!(out, redirect("rtsp://127.0.0.1:5004/moved").as_bytes());
        }
    }

    #[test]
    fn a_password_passes_in_clear_only_where_that_is_permitted() {
        let request =
            |scheme: &str| format!("DESCRIBE rtsp://h/ RTSP/1.0\r\nauthorization:{scheme} dTpw\r\n\r\n");
        for (scheme, is_basic) in [(" Basic", true), ("basic", true), (" Digest", false)] {
            for permits_basic in [false, true] {
                let mut out = Vec::new();
                let passed = Requests::new(permits_basic).pass(request(scheme).as_bytes(), &mut out);
                if is_basic && !permits_basic {
                    assert_eq!(passed, Err(Refusal::BasicInClear));
                    assert!(out.is_empty());
                } else {
                    assert_eq!(passed, Ok(Some("DESCRIBE".to_owned())));
                    assert_eq!(out, request(scheme).as_bytes());
                }
            }
        }
    }
}
