//! MAVLink frames: found in a stream of bytes, and written.
//!
//! A frame of version 2 is 0xFD, payload length, incompatibility flags, compatibility flags, sequence,
//! system, component, message id (3 bytes), payload, CRC (2 bytes), and 13 bytes of signature where flag 1 is
//! set; a frame of version 1 is 0xFE, payload length, sequence, system, component, message id, payload, CRC.
//! The CRC covers all between the first byte and itself, and a number that stands for the message's
//! definition.

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::Address;
use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message, MessageData, calculate_crc};

use super::signing::{SIGNATURE_BYTES, Signer, Signing, Verifier};

/// Bytes of a frame before its payload, of version 1 and 2.
const HEADER_BYTES: (usize, usize) = (6, 10);
const CRC_BYTES: usize = 2;
const MAX_PAYLOAD_BYTES: usize = 255;
/// The incompatibility flag of a signature.
const SIGNED: u8 = 1;

/// A frame whose CRC is right.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame<'a> {
    /// The sender.
    pub from: Address,
    /// The id of the message.
    pub message: u32,
    version: MavlinkVersion,
    payload: &'a [u8],
    /// What is signed: from the first byte to the CRC.
    signed: &'a [u8],
    /// Empty without a signature.
    signature: &'a [u8],
}

impl Frame<'_> {
    /// The payload as received: zeros at its end may be left out.
    pub const fn payload(&self) -> &[u8] {
        self.payload
    }

    /// The content, as the message `D`; `None`: another message, or one with a value that the message does
    /// not have.
    pub fn read<D: MessageData>(&self) -> Option<D> {
        (self.message == D::ID).then(|| D::deser(self.version, self.payload).ok()).flatten()
    }
}

/// What begins at a byte.
enum Found<'a> {
    /// A frame of this length.
    Frame(Frame<'a>, usize),
    /// What may become a frame.
    Incomplete,
    Nothing,
}

/// Finds frames in a stream of bytes: in any pieces, several in one, damaged, with anything between them.
///
/// Bytes that look like the beginning of a long frame hold nothing up: a whole frame behind them is found at
/// once.
#[derive(Debug, Clone, Default)]
pub struct FrameReader {
    /// What may be the beginning of a frame: less than a frame between two calls.
    bytes: Vec<u8>,
    verifier: Option<Verifier>,
}

impl FrameReader {
    /// With `signing`, frames whose signature is missing, wrong or old are left out.
    pub fn new(signing: Option<Signing>, now: Timestamp) -> Self {
        Self { bytes: Vec::new(), verifier: signing.map(|signing| Verifier::new(signing, now)) }
    }

    /// Passes each frame to `each`.
    pub fn read(&mut self, bytes: &[u8], mut each: impl FnMut(&Frame<'_>)) {
        self.bytes.extend_from_slice(bytes);
        let (mut at, mut incomplete_at) = (0, None);
        while at < self.bytes.len() {
            match found(&self.bytes[at..]) {
                Found::Frame(frame, length) => {
                    let is_accepted = self
                        .verifier
                        .as_mut()
                        .is_none_or(|verifier| verifier.accepts(frame.from, frame.signed, frame.signature));
                    if is_accepted {
                        each(&frame);
                    }
                    at += length;
                    incomplete_at = None;
                }
                Found::Incomplete => {
                    incomplete_at.get_or_insert(at);
                    at += 1;
                }
                Found::Nothing => at += 1,
            }
        }
        self.bytes.drain(..incomplete_at.unwrap_or(at));
    }
}

fn found(bytes: &[u8]) -> Found<'_> {
    let (version, header) = match bytes[0] {
        MAV_STX => (MavlinkVersion::V1, HEADER_BYTES.0),
        MAV_STX_V2 => (MavlinkVersion::V2, HEADER_BYTES.1),
        _ => return Found::Nothing,
    };
    let flags = if version == MavlinkVersion::V2 { bytes.get(2).copied().unwrap_or(0) } else { 0 };
    if flags & !SIGNED != 0 {
        return Found::Nothing;
    }
    let Some(head) = bytes.get(..header) else { return Found::Incomplete };
    let payload_end = header + usize::from(head[1]);
    let (from, message) = match version {
        MavlinkVersion::V1 => (Address::new(head[3], head[4]), u32::from(head[5])),
        MavlinkVersion::V2 => {
            (Address::new(head[5], head[6]), u32::from_le_bytes([head[7], head[8], head[9], 0]))
        }
    };
    let length = payload_end + CRC_BYTES + if flags & SIGNED == 0 { 0 } else { SIGNATURE_BYTES };
    let Some(frame) = bytes.get(..length) else { return Found::Incomplete };
    let crc = u16::from_le_bytes([frame[payload_end], frame[payload_end + 1]]);
    if calculate_crc(&frame[1..payload_end], MavMessage::extra_crc(message)) != crc {
        return Found::Nothing;
    }
    let (signed, signature) = frame.split_at(payload_end + CRC_BYTES);
    let payload = &frame[header..payload_end];
    Found::Frame(Frame { from, message, version, payload, signed, signature }, length)
}

/// Writes frames of version 2 with the sequence numbers of one sender.
#[derive(Debug, Clone)]
pub struct FrameWriter {
    from: Address,
    sequence: u8,
    signer: Option<Signer>,
}

impl FrameWriter {
    /// A writer of frames from this address; with `signing`, of signed ones.
    pub fn new(from: Address, signing: Option<Signing>) -> Self {
        Self { from, sequence: 0, signer: signing.map(Signer::new) }
    }

    /// The time of the next signatures.
    pub fn set_time(&mut self, now: Timestamp) {
        if let Some(signer) = &mut self.signer {
            signer.set_time(now);
        }
    }

    /// The signatures of frames that were read so far are not newer than the next ones: the clock of this
    /// machine may be behind.
    pub fn follow(&mut self, reader: &FrameReader) {
        if let (Some(signer), Some(verifier)) = (&mut self.signer, &reader.verifier) {
            signer.follow(verifier.newest());
        }
    }

    /// Sends from another address from now on.
    pub const fn set_address(&mut self, from: Address) {
        self.from = from;
    }

    /// The sender.
    pub const fn address(&self) -> Address {
        self.from
    }

    /// A message as a packet.
    pub fn write<D: MessageData>(&mut self, message: &D) -> Vec<u8> {
        let mut payload = [0; MAX_PAYLOAD_BYTES];
        let length = message.ser(MavlinkVersion::V2, &mut payload);
        self.write_payload(D::ID, &payload[..length])
    }

    /// A message with this id and payload as a packet; what is beyond the longest payload is left out.
    pub fn write_payload(&mut self, message: u32, payload: &[u8]) -> Vec<u8> {
        let payload = &payload[..payload.len().min(MAX_PAYLOAD_BYTES)];
        let [id_low, id_middle, id_high, _] = message.to_le_bytes();
        let flags = if self.signer.is_some() { SIGNED } else { 0 };
        let (system, component) = (self.from.system.0, self.from.component.0);
        let length = payload.len() as u8;
        let head =
            [MAV_STX_V2, length, flags, 0, self.sequence, system, component, id_low, id_middle, id_high];
        self.sequence = self.sequence.wrapping_add(1);
        let mut packet = [&head, payload].concat();
        let crc = calculate_crc(&packet[1..], MavMessage::extra_crc(message));
        packet.extend_from_slice(&crc.to_le_bytes());
        if let Some(signer) = &mut self.signer {
            let signature = signer.sign(&packet);
            packet.extend_from_slice(&signature);
        }
        packet
    }
}
