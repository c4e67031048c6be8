//! What may pass between an RTSP server and this program: whole messages within bounds, and no password in
//! clear.
//!
//! The RTSP library keeps what a server sends until a message or an access unit is whole, without a bound,
//! and sends a password as Basic to a server that offers nothing else. This filter stands between the two
//! ([`super::rtsp_relay`]); it is a plain state machine without I/O.
//!
//! - A head has at most 64 KiB, a body (SDP) 256 KiB, and an access unit (packets of one RTP time) 8 MiB.
//!   What is larger ends the connection.
//! - A request with `Authorization: Basic` passes only where that is permitted.
//! - `Content-Base` and `Content-Location` lead through the relay: a server cannot name another host.
//! - A request of the server itself (`OPTIONS`, `GET_PARAMETER`) is answered with 501 here.

use std::net::SocketAddr;

/// Longest head of a message, bytes.
const MAX_HEAD_BYTES: usize = 64 << 10;
/// Longest body of a message, bytes.
const MAX_BODY_BYTES: usize = 256 << 10;
/// Largest access unit, bytes: a key frame of 4K video has less than 2 MiB.
const MAX_UNIT_BYTES: usize = 8 << 20;
/// The second byte of an RTCP packet.
const RTCP_KINDS: core::ops::RangeInclusive<u8> = 192..=223;
/// Length of the header of interleaved data, and of the part of an RTP header that holds its time.
const INTERLEAVED_HEADER: usize = 4;
const RTP_TIME_END: usize = 8;

/// Why a connection is ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refusal {
    #[error("the server sent a head of more than {} KiB", MAX_HEAD_BYTES >> 10)]
    LongHead,
    #[error("the server announced a body of more than {} KiB", MAX_BODY_BYTES >> 10)]
    LongBody,
    #[error("the server sent an access unit of more than {} MiB", MAX_UNIT_BYTES >> 20)]
    LongUnit,
    #[error("the server sent what is not RTSP")]
    NotRtsp,
    #[error("the server takes a password in clear text only (Basic, without TLS)")]
    BasicInClear,
}

/// A message at the beginning of what was received.
#[derive(Debug, PartialEq, Eq)]
enum Message {
    /// Line ends between messages.
    Blank { length: usize },
    /// Interleaved data of this channel.
    Data { channel: u8, length: usize },
    /// A request or an answer: the length of its head, and of all of it.
    Text { head: usize, length: usize },
}

/// The first message, if it is whole.
fn first_message(bytes: &[u8]) -> Result<Option<Message>, Refusal> {
    match bytes {
        [] => Ok(None),
        [b'\r' | b'\n', ..] => {
            let length = bytes.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
            Ok(Some(Message::Blank { length }))
        }
        [b'$', channel, high, low, ..] => {
            let length = INTERLEAVED_HEADER + usize::from(u16::from_be_bytes([*high, *low]));
            Ok((bytes.len() >= length).then_some(Message::Data { channel: *channel, length }))
        }
        [b'$', ..] => Ok(None),
        _ => first_text(bytes),
    }
}

fn first_text(bytes: &[u8]) -> Result<Option<Message>, Refusal> {
    let Some(head) = head_length(&bytes[..bytes.len().min(MAX_HEAD_BYTES)]) else {
        return if bytes.len() >= MAX_HEAD_BYTES { Err(Refusal::LongHead) } else { Ok(None) };
    };
    let length = head + body_length(&bytes[..head])?;
    Ok((bytes.len() >= length).then_some(Message::Text { head, length }))
}

/// The length of a head with the empty line at its end.
fn head_length(bytes: &[u8]) -> Option<usize> {
    let is_end = |at: &usize| bytes[..*at].ends_with(b"\n\r\n") || bytes[..*at].ends_with(b"\n\n");
    let line_ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
    line_ends.into_iter().find(is_end)
}

/// The lines of a head.
fn lines(head: &[u8]) -> impl Iterator<Item = &[u8]> {
    head.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_end)
}

/// The value of a header line of this name.
fn value<'a>(line: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let colon = line.iter().position(|byte| *byte == b':')?;
    let (before, after) = line.split_at(colon);
    before.trim_ascii().eq_ignore_ascii_case(name.as_bytes()).then(|| after[1..].trim_ascii())
}

/// The announced length of the body. Two that differ, and what is no number, would be read differently
/// elsewhere.
fn body_length(head: &[u8]) -> Result<usize, Refusal> {
    let mut length = None;
    for text in lines(head).filter_map(|line| value(line, "Content-Length")) {
        let is_number = !text.is_empty() && text.iter().all(u8::is_ascii_digit);
        let number = std::str::from_utf8(text).ok().filter(|_| is_number).ok_or(Refusal::NotRtsp)?;
        let number = number.parse().unwrap_or(usize::MAX);
        if number > MAX_BODY_BYTES {
            return Err(Refusal::LongBody);
        }
        if length.replace(number).is_some_and(|before| before != number) {
            return Err(Refusal::NotRtsp);
        }
    }
    Ok(length.unwrap_or(0))
}

/// The requests of this program on their way to the server.
#[derive(Debug)]
pub(super) struct RequestFilter {
    permits_basic: bool,
    held: Vec<u8>,
}

impl RequestFilter {
    /// `permits_basic`: whether a password may be sent as it is.
    pub(super) const fn new(permits_basic: bool) -> Self {
        Self { permits_basic, held: Vec::new() }
    }

    /// Takes bytes, and appends the whole messages to `out`.
    ///
    /// # Errors
    /// [`Refusal::BasicInClear`]: nothing of that request was appended.
    pub(super) fn pass(&mut self, bytes: &[u8], out: &mut Vec<u8>) -> Result<(), Refusal> {
        self.held.extend_from_slice(bytes);
        while let Some(message) = first_message(&self.held)? {
            let length = match message {
                Message::Text { head, length } => {
                    let is_basic = |line: &[u8]| {
                        value(line, "Authorization").is_some_and(|text| {
                            text.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"basic"))
                        })
                    };
                    if !self.permits_basic && lines(&self.held[..head]).any(is_basic) {
                        return Err(Refusal::BasicInClear);
                    }
                    length
                }
                Message::Blank { length } | Message::Data { length, .. } => length,
            };
            out.extend(self.held.drain(..length));
        }
        Ok(())
    }
}

/// What the server sends on its way to this program.
#[derive(Debug)]
pub(super) struct AnswerFilter {
    relay: SocketAddr,
    held: Vec<u8>,
    /// The RTP time of the access unit of each channel, and its bytes so far.
    units: Vec<(u32, usize)>,
    /// Requests of the server that were answered here.
    requests: u64,
}

impl AnswerFilter {
    /// `relay`: where this program reaches the server.
    pub(super) fn new(relay: SocketAddr) -> Self {
        Self { relay, held: Vec::new(), units: vec![(0, 0); 256], requests: 0 }
    }

    /// Requests of the server so far.
    pub(super) const fn requests(&self) -> u64 {
        self.requests
    }

    /// Takes bytes of the server. Appends the whole messages to `out`, and what the server is answered to
    /// `back`.
    ///
    /// # Errors
    /// [`Refusal`]: the connection is to be ended.
    pub(super) fn pass(
        &mut self,
        bytes: &[u8],
        out: &mut Vec<u8>,
        back: &mut Vec<u8>,
    ) -> Result<(), Refusal> {
        self.held.extend_from_slice(bytes);
        let mut read = 0;
        while let Some(message) = first_message(&self.held[read..])? {
            let rest = &self.held[read..];
            let length = match message {
                Message::Blank { length } => {
                    out.extend_from_slice(&rest[..length]);
                    length
                }
                Message::Data { channel, length } => {
                    let (channel, data) = (usize::from(channel), &rest[INTERLEAVED_HEADER..length]);
                    count_unit(&mut self.units[channel], data)?;
                    out.extend_from_slice(&rest[..length]);
                    length
                }
                Message::Text { head, length } => {
                    let text = &rest[..head];
                    if text.starts_with(b"RTSP/") {
                        put_answer(text, self.relay, out);
                        out.extend_from_slice(&rest[head..length]);
                    } else if text.trim_ascii_end().ends_with(b"RTSP/1.0") || has_version(text) {
                        self.requests += 1;
                        put_refusal(text, back);
                    } else {
                        return Err(Refusal::NotRtsp);
                    }
                    length
                }
            };
            read += length;
        }
        self.held.drain(..read);
        Ok(())
    }
}

/// Whether the first line is that of a request.
fn has_version(head: &[u8]) -> bool {
    lines(head).next().is_some_and(|line| line.windows(6).any(|word| word == b" RTSP/"))
}

/// Counts an RTP packet to the access unit of its time. Reports of the sender (RTCP, RFC 5761) have no time
/// there, and belong to no unit.
fn count_unit(unit: &mut (u32, usize), packet: &[u8]) -> Result<(), Refusal> {
    if packet.get(1).is_some_and(|kind| RTCP_KINDS.contains(kind)) {
        return Ok(());
    }
    let time = packet
        .get(..RTP_TIME_END)
        .map_or(unit.0, |header| u32::from_be_bytes([header[4], header[5], header[6], header[7]]));
    if time != unit.0 {
        *unit = (time, 0);
    }
    unit.1 += packet.len();
    if unit.1 > MAX_UNIT_BYTES { Err(Refusal::LongUnit) } else { Ok(()) }
}

/// Appends the head of an answer. Addresses that say where the stream is lead through the relay.
fn put_answer(head: &[u8], relay: SocketAddr, out: &mut Vec<u8>) {
    for line in head.split_inclusive(|byte| *byte == b'\n') {
        let address = ["Content-Base", "Content-Location"].into_iter().find_map(|name| {
            let text = std::str::from_utf8(value(line.trim_ascii_end(), name)?).ok()?;
            let (_, rest) = text.split_once("://")?;
            Some((name, rest.find(['/', '?']).map_or("", |at| &rest[at..])))
        });
        match address {
            Some((name, path)) => {
                out.extend_from_slice(format!("{name}: rtsp://{relay}{path}\r\n").as_bytes())
            }
            None => out.extend_from_slice(line),
        }
    }
}

/// Appends the answer to a request of the server.
fn put_refusal(head: &[u8], back: &mut Vec<u8>) {
    back.extend_from_slice(b"RTSP/1.0 501 Not Implemented\r\n");
    if let Some(cseq) = lines(head).find_map(|line| value(line, "CSeq")) {
        back.extend_from_slice(b"CSeq: ");
        back.extend_from_slice(cseq);
        back.extend_from_slice(b"\r\n");
    }
    back.extend_from_slice(b"\r\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    const RELAY: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 5004);

    /// What passes of the server's bytes, which arrive in parts of this size; and what the server is
    /// answered.
    fn passed(bytes: &[u8], part: usize) -> Result<(Vec<u8>, Vec<u8>), Refusal> {
        let mut filter = AnswerFilter::new(RELAY);
        let (mut out, mut back) = (Vec::new(), Vec::new());
        for part in bytes.chunks(part) {
            filter.pass(part, &mut out, &mut back)?;
        }
        Ok((out, back))
    }

    fn data(channel: u8, packet: &[u8]) -> Vec<u8> {
        let length = (packet.len() as u16).to_be_bytes();
        [&[b'$', channel], &length[..], packet].concat()
    }

    #[test]
    fn messages_pass_unchanged_in_whatever_parts_they_arrive() {
        let answer = b"RTSP/1.0 200 OK\r\nCSeq: 1\r\nContent-Length: 5\r\n\r\nv=0\r\n".to_vec();
        let stream = [answer.clone(), data(0, &[0x80; 40]), b"\r\n".to_vec(), answer, data(1, b"")].concat();
        for part in [1, 2, 3, 7, 64, stream.len()] {
            assert_eq!(passed(&stream, part), Ok((stream.clone(), Vec::new())), "{part}");
        }
    }

    #[test]
    fn what_has_no_bound_ends_the_connection() {
        let head = b"RTSP/1.0 200 OK\r\nX: ".to_vec();
        let long_head = [head, vec![b'a'; MAX_HEAD_BYTES]].concat();
        let lengths = |text: &str| format!("RTSP/1.0 200 OK\r\n{text}\r\n\r\n").into_bytes();
        let endless: Vec<u8> = data(0, &[7; 60_000]).repeat(MAX_UNIT_BYTES / 60_000 + 1);
        for (stream, refusal) in [
            (long_head, Refusal::LongHead),
            (vec![b'\x7f'; MAX_HEAD_BYTES], Refusal::LongHead),
            (lengths("Content-Length: 262145"), Refusal::LongBody),
            (lengths("content-length : 4294967295"), Refusal::LongBody),
            (lengths("Content-Length: 99999999999999999999999"), Refusal::LongBody),
            (lengths("Content-Length: -1"), Refusal::NotRtsp),
            (lengths("Content-Length: 5\r\nContent-Length: 6"), Refusal::NotRtsp),
            (b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec(), Refusal::NotRtsp),
            (endless, Refusal::LongUnit),
        ] {
            assert_eq!(passed(&stream, 4096), Err(refusal));
        }
    }

    #[test]
    fn access_units_that_end_are_bounded_each_by_itself() {
        let mut stream = Vec::new();
        for time in 0..300_u32 {
            let packet = [&[0x80, 96, 0, 0], &time.to_be_bytes()[..], &[1; 60_000]].concat();
            stream.extend(data(0, &packet));
        }
        assert!(stream.len() > 2 * MAX_UNIT_BYTES);
        assert!(passed(&stream, 4096).is_ok());
    }

    #[test]
    fn reports_of_the_sender_are_no_part_of_an_access_unit() {
        let report = [&[0x80, 200, 0, 6][..], &[7; 24]].concat();
        let stream = data(1, &report).repeat(MAX_UNIT_BYTES / report.len() + 1);
        assert!(passed(&stream, 1 << 16).is_ok());
    }

    #[test]
    fn a_server_cannot_name_another_host() {
        for (line, path) in [
            ("Content-Base: rtsp://10.0.0.1:554/live/", "/live/"),
            ("content-location:rtsps://cam.example?x=1", "?x=1"),
        ] {
            let (out, _) = passed(format!("RTSP/1.0 200 OK\r\n{line}\r\n\r\n").as_bytes(), 99).unwrap();
            let out = String::from_utf8(out).unwrap();
            assert!(out.contains(&format!(": rtsp://127.0.0.1:5004{path}\r\n")), "{out}");
            assert!(!out.contains("example") && !out.contains("10.0.0.1"), "{out}");
        }
    }

    #[test]
    fn a_request_of_the_server_is_answered_and_not_passed_on() {
        let request = b"OPTIONS rtsp://127.0.0.1/ RTSP/1.0\r\nCSeq: 31\r\nContent-Length: 2\r\n\r\nhi";
        let (out, back) = passed(request, 5).unwrap();
        assert!(out.is_empty());
        assert_eq!(back, b"RTSP/1.0 501 Not Implemented\r\nCSeq: 31\r\n\r\n");
    }

    #[test]
    fn a_password_passes_in_clear_only_where_that_is_permitted() {
        let request = |authorization: &str| {
            format!("DESCRIBE rtsp://h/ RTSP/1.0\r\nCSeq: 2\r\n{authorization}\r\n\r\n").into_bytes()
        };
        for (authorization, is_basic) in [
            ("Authorization: Basic dTpw", true),
            ("authorization:basic dTpw", true),
            ("Authorization: Digest username=\"u\"", false),
            ("X: Basic", false),
        ] {
            for permits_basic in [false, true] {
                let mut out = Vec::new();
                let sent = RequestFilter::new(permits_basic).pass(&request(authorization), &mut out);
                let is_refused = is_basic && !permits_basic;
                assert_eq!(sent, if is_refused { Err(Refusal::BasicInClear) } else { Ok(()) });
                assert_eq!(out, if is_refused { Vec::new() } else { request(authorization) });
            }
        }
    }
}
