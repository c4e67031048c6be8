//! Signatures of packets: who does not know the secret key can neither command nor report.
//!
//! A signature is 13 bytes behind a frame of version 2: the id of the link, the time (6 bytes, little-endian,
//! in units of 10 us since the beginning of 2015), and the first 6 bytes of the SHA-256 of the key, the
//! frame, the id of the link and the time. The time of a sender and link never repeats, so that a packet
//! cannot be sent again by a listener. A sender that is new may be at most one minute behind the newest time
//! that is known ([MAVLink's page on message signing][page]).
//!
//! [page]: https://mavlink.io/en/guide/message_signing.html

use core::fmt;

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::Address;
use sha2::{Digest as _, Sha256};

/// Bytes of a secret key.
pub const KEY_BYTES: usize = 32;
/// Bytes of a signature.
pub const SIGNATURE_BYTES: usize = 13;
/// Bytes of a signature before its hash.
const STAMP_BYTES: usize = 7;
/// Units of the time in a second.
const UNITS_PER_S: u64 = 100_000;
/// A sender that is new may be this far behind, units.
const MAX_BEHIND: u64 = 60 * UNITS_PER_S;
/// The beginning of 2015, seconds since that of 1970.
const EPOCH_S: u64 = 1_420_070_400;
/// Largest number of senders whose times are kept.
const MAX_SENDERS: usize = 32;

/// A secret key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SigningKey([u8; KEY_BYTES]);

/// Does not show the key.
impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SigningKey")
    }
}

/// The text of a key is not usable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EmptyKey;

impl fmt::Display for EmptyKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the first line is empty: write 64 hexadecimal digits, or a passphrase")
    }
}

impl core::error::Error for EmptyKey {}

impl SigningKey {
    /// The key of these bytes.
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// The key in a text: 64 hexadecimal digits, or a passphrase, whose SHA-256 is the key, as ground
    /// stations derive it.
    ///
    /// # Errors
    /// If the first line is empty.
    pub fn parse(text: &str) -> Result<Self, EmptyKey> {
        let line = text.lines().next().unwrap_or_default().trim();
        if line.is_empty() {
            return Err(EmptyKey);
        }
        let digits: Option<Vec<u8>> = line.chars().map(|c| c.to_digit(16).map(|digit| digit as u8)).collect();
        Ok(Self(match digits {
            Some(digits) if digits.len() == 2 * KEY_BYTES => {
                core::array::from_fn(|index| digits[2 * index] << 4 | digits[2 * index + 1])
            }
            _ => Sha256::digest(line.as_bytes()).into(),
        }))
    }

    /// The bytes, for another process of this program.
    pub const fn bytes(&self) -> [u8; KEY_BYTES] {
        self.0
    }

    fn hash(&self, frame: &[u8], stamp: &[u8]) -> [u8; SIGNATURE_BYTES - STAMP_BYTES] {
        let digest = Sha256::new().chain_update(self.0).chain_update(frame).chain_update(stamp).finalize();
        core::array::from_fn(|index| digest[index])
    }
}

/// What a link needs to sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signing {
    /// The key.
    pub key: SigningKey,
    /// The time at the start of the program's clock, in units of 10 us since the beginning of 2015.
    pub began: u64,
}

impl Signing {
    /// Signatures with this key. `began_unix_ms`: the start of the program's clock, milliseconds since the
    /// beginning of 1970.
    pub const fn new(key: SigningKey, began_unix_ms: u64) -> Self {
        let began = began_unix_ms.saturating_sub(EPOCH_S * 1_000) * (UNITS_PER_S / 1_000);
        Self { key, began }
    }

    /// The time of the program's clock, in units of 10 us since the beginning of 2015.
    const fn at(&self, now: Timestamp) -> u64 {
        self.began + now.as_nanos() / (1_000_000_000 / UNITS_PER_S)
    }
}

/// Signs the frames of one sender.
#[derive(Debug, Clone)]
pub(super) struct Signer {
    signing: Signing,
    /// The time of the next signature, if the clock has not gone on.
    next: u64,
}

impl Signer {
    pub(super) const fn new(signing: Signing) -> Self {
        Self { signing, next: signing.began }
    }

    /// The clock has gone on.
    pub(super) fn set_time(&mut self, now: Timestamp) {
        self.next = self.next.max(self.signing.at(now));
    }

    /// A frame of this time was accepted. Its sender would take one of an earlier time for a repetition.
    pub(super) fn follow(&mut self, newest: u64) {
        self.next = self.next.max(newest + 1);
    }

    /// The signature of a frame, from its first byte to its CRC.
    pub(super) fn sign(&mut self, frame: &[u8]) -> [u8; SIGNATURE_BYTES] {
        let mut signature = [0; SIGNATURE_BYTES];
        signature[1..STAMP_BYTES].copy_from_slice(&self.next.to_le_bytes()[..STAMP_BYTES - 1]);
        self.next += 1;
        let hash = self.signing.key.hash(frame, &signature[..STAMP_BYTES]);
        signature[STAMP_BYTES..].copy_from_slice(&hash);
        signature
    }
}

/// Tells the frames that were signed with a key, each once.
#[derive(Debug, Clone)]
pub(super) struct Verifier {
    key: SigningKey,
    newest: u64,
    /// The newest time of each sender and link.
    senders: Vec<(Address, u8, u64)>,
}

impl Verifier {
    /// Of a link that is opened now: what a listener has recorded earlier is not accepted.
    pub(super) const fn new(signing: Signing, now: Timestamp) -> Self {
        Self { key: signing.key, newest: signing.at(now), senders: Vec::new() }
    }

    /// The newest time of a frame that was accepted; at first that of the link's opening.
    pub(super) const fn newest(&self) -> u64 {
        self.newest
    }

    /// Whether the signature of a frame is right, and newer than the one before.
    pub(super) fn accepts(&mut self, from: Address, frame: &[u8], signature: &[u8]) -> bool {
        let Some((stamp, hash)) = signature.split_at_checked(STAMP_BYTES) else { return false };
        if self.key.hash(frame, stamp)[..] != *hash {
            return false;
        }
        let link = stamp[0];
        let mut time = [0; 8];
        time[..STAMP_BYTES - 1].copy_from_slice(&stamp[1..]);
        let time = u64::from_le_bytes(time);
        let has_room = self.senders.len() < MAX_SENDERS;
        let known = self.senders.iter_mut().find(|(known, id, _)| (*known, *id) == (from, link));
        let is_new = match known {
            Some((_, _, last)) if *last < time => {
                *last = time;
                true
            }
            Some(_) => false,
            None if has_room && time.saturating_add(MAX_BEHIND) >= self.newest => {
                self.senders.push((from, link, time));
                true
            }
            None => false,
        };
        if is_new {
            self.newest = self.newest.max(time);
        }
        is_new
    }
}
