//! Received H.264 and H.265 for the pages, unchanged, with the group of pictures that a new page needs to
//! begin.

use std::sync::{Mutex, MutexGuard, PoisonError};

use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{EncodedUnit, VideoNumber};
use bytes::Bytes;
use tokio::sync::broadcast;

use super::api::{EncodedVideo, VideoHead, VideoKind};

/// Units that a page may be behind before it loses some: about one second.
const BACKLOG: usize = 32;
/// Largest group of pictures that is kept for new pages. With a longer one, a new page waits for the next key
/// frame.
const MAX_GROUP_UNITS: usize = 600;
const MAX_GROUP_BYTES: usize = 16 << 20;

/// One unit as a message, with what a sender must know of it.
#[derive(Debug, Clone)]
pub(super) struct RelayedUnit {
    /// Head and payload.
    pub(super) message: Bytes,
    /// Whether decoding can start here.
    pub(super) key: bool,
}

#[derive(Debug, Default)]
struct Group {
    codec: Option<EncodedVideo>,
    units: Vec<RelayedUnit>,
    bytes: usize,
}

impl Group {
    fn clear(&mut self) {
        self.units.clear();
        self.bytes = 0;
    }
}

/// Passes H.264 and H.265 units on to the pages. Adding a unit never waits for a page.
#[derive(Debug)]
pub struct VideoRelay {
    number: VideoNumber,
    group: Mutex<Group>,
    units: broadcast::Sender<RelayedUnit>,
}

impl VideoRelay {
    /// Nothing so far of this video.
    pub fn new(number: VideoNumber) -> Self {
        Self { number, group: Mutex::default(), units: broadcast::channel(BACKLOG).0 }
    }

    /// Adds a unit. Units of another codec are not relayed.
    pub fn add(&self, unit: &EncodedUnit) {
        let codec = match unit.codec {
            UnitCodec::H264AnnexB => Some((EncodedVideo::H264, VideoKind::H264)),
            UnitCodec::H265AnnexB => Some((EncodedVideo::H265, VideoKind::H265)),
            UnitCodec::Vp9
            | UnitCodec::Av1
            | UnitCodec::Jpeg
            | UnitCodec::Png
            | UnitCodec::RawYuv420 { .. } => None,
        };
        let mut group = self.group();
        group.codec = codec.map(|(codec, _)| codec);
        let Some((_, kind)) = codec else { return };
        let unit = RelayedUnit {
            message: VideoHead::of_unit(kind, unit, self.number).message(&unit.payload).into(),
            key: unit.key,
        };
        if unit.key {
            group.clear();
        }
        let is_decodable = unit.key || !group.units.is_empty();
        group.bytes += unit.message.len();
        if group.units.len() >= MAX_GROUP_UNITS || group.bytes > MAX_GROUP_BYTES {
            group.clear();
        } else if is_decodable {
            group.units.push(unit.clone());
        }
        // Sent under the lock, so that a new page gets each unit once. No page: nothing to send.
        let _ = self.units.send(unit);
    }

    /// The codec of the newest unit, if units of it are relayed.
    pub(super) fn codec(&self) -> Option<EncodedVideo> {
        self.group().codec
    }

    /// The units since the newest key frame, and a receiver of those that follow.
    pub(super) fn subscribe(&self) -> (Vec<RelayedUnit>, broadcast::Receiver<RelayedUnit>) {
        let group = self.group();
        (group.units.clone(), self.units.subscribe())
    }

    fn group(&self) -> MutexGuard<'_, Group> {
        self.group.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Timestamp;
    use barrelman_vocab::unit::Rotation;
    use barrelman_vocab::video::{Capture, CaptureQuality};

    use super::*;

    fn unit(index: u64, key: bool) -> EncodedUnit {
        EncodedUnit {
            epoch: 0,
            index,
            capture: Capture { at: Timestamp::from_nanos(index), quality: CaptureQuality::Sender },
            key,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: Bytes::from_static(&[1, 2, 3]),
        }
    }

    fn indices(units: &[RelayedUnit]) -> Vec<u8> {
        units.iter().map(|unit| unit.message[16]).collect()
    }

    #[test]
    fn a_new_page_begins_with_the_newest_key_frame() {
        let relay = VideoRelay::new(VideoNumber::First);
        for (index, key) in [(0, false), (1, true), (2, false), (3, true), (4, false)] {
            relay.add(&unit(index, key));
        }
        let (group, mut later) = relay.subscribe();
        assert_eq!(indices(&group), [3, 4]);
        relay.add(&unit(5, false));
        assert_eq!(later.try_recv().map(|unit| unit.message[16]).ok(), Some(5));
    }

    #[test]
    fn a_group_without_end_is_given_up_until_the_next_key_frame() {
        let relay = VideoRelay::new(VideoNumber::First);
        relay.add(&unit(0, true));
        for index in 1..2 * MAX_GROUP_UNITS as u64 {
            relay.add(&unit(index, false));
        }
        assert!(relay.subscribe().0.is_empty());
        relay.add(&unit(7, true));
        assert_eq!(indices(&relay.subscribe().0), [7]);
    }
}
