//! Packets that the elements behind do not bear: broken ones, and parameter sets that are repeated inside of
//! a picture.
//!
//! Depayloaders of GStreamer read beyond the end of a packet whose payload is shorter than its head says, so
//! that such packets are left out here.
//!
//! A payloader that is to send the parameter sets with each key picture may send them with each slice of it
//! (GStreamer's `rtph264pay config-interval=-1` does). A set, a delimiter or an SEI begins a new access unit
//! (ITU-T H.264, 7.4.1.2.3; H.265, 7.4.2.4.4), so that the picture would be torn. They become filler data
//! here, which belongs to any picture; the packets stay, since a gap in their numbers would be a loss.

/// The formats whose packets are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Nal {
    H264,
    H265,
}

/// What a packet begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Slice,
    /// What begins an access unit.
    Beginning,
    Other,
}

impl Nal {
    /// The format of an encoding name.
    pub(super) fn of(encoding: &str) -> Option<Self> {
        match encoding {
            "H264" => Some(Self::H264),
            "H265" => Some(Self::H265),
            _ => None,
        }
    }

    fn kind(self, payload: &[u8]) -> Kind {
        let [first, second, ..] = *payload else { return Kind::Other };
        match self {
            Self::H264 => match (first & 0x1f, second & 0x1f) {
                (1..=5, _) | (28, 1..=5) => Kind::Slice,
                (6..=9, _) => Kind::Beginning,
                _ => Kind::Other,
            },
            Self::H265 => match (first >> 1 & 0x3f, payload.get(2).map(|unit| unit & 0x3f)) {
                (0..=31, _) | (49, Some(0..=31)) => Kind::Slice,
                (32..=35 | 39, _) => Kind::Beginning,
                _ => Kind::Other,
            },
        }
    }

    /// Whether the payload has the parts that its head announces (RFC 6184, 5.6 to 5.8; RFC 7798, 4.4).
    pub(super) fn is_sound(self, payload: &[u8]) -> bool {
        let Some(first) = payload.first() else { return false };
        match self {
            Self::H264 => match first & 0x1f {
                24 => holds_units(&payload[1..], 1),
                28 => payload.len() > 2,
                1..=23 => payload.len() > 1,
                _ => false,
            },
            Self::H265 => match first >> 1 & 0x3f {
                48 => payload.len() > 2 && holds_units(&payload[2..], 2),
                49 => payload.len() > 3,
                0..=47 => payload.len() > 2,
                _ => false,
            },
        }
    }

    /// The head of filler data.
    fn filler(self, first: u8) -> u8 {
        match self {
            Self::H264 => first & 0xe0 | 12,
            Self::H265 => first & 0x81 | 38 << 1,
        }
    }
}

/// Whether an aggregation consists of whole units, each longer than its head.
fn holds_units(mut units: &[u8], head: usize) -> bool {
    while let [high, low, rest @ ..] = units {
        let length = usize::from(u16::from_be_bytes([*high, *low]));
        if length <= head || length > rest.len() {
            return false;
        }
        units = &rest[length..];
    }
    units.is_empty()
}

/// Follows the packets of a stream in their order.
#[derive(Debug)]
pub(super) struct RepeatedSets {
    nal: Nal,
    /// Time stamp of the last packet with a slice.
    slice: Option<u32>,
}

impl RepeatedSets {
    pub(super) fn new(nal: Nal) -> Self {
        Self { nal, slice: None }
    }

    /// Whether the payload can be passed on.
    pub(super) fn is_sound(&self, payload: &[u8]) -> bool {
        self.nal.is_sound(payload)
    }

    /// The first byte that the payload is to have instead of its own, if it repeats something.
    pub(super) fn on_packet(&mut self, ticks: u32, payload: &[u8]) -> Option<u8> {
        match self.nal.kind(payload) {
            Kind::Slice => {
                self.slice = Some(ticks);
                None
            }
            Kind::Beginning if self.slice == Some(ticks) => Some(self.nal.filler(payload[0])),
            Kind::Beginning | Kind::Other => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_that_lack_a_part_are_unsound() {
        let h264: [(&[u8], bool); 6] = [
            (&[0x65, 1], true),
            (&[0x7c, 0x85], false),
            (&[0x7c, 0x85, 1], true),
            (&[0x78, 0, 2, 0x67, 1, 0, 2, 0x68, 1], true),
            (&[0x78, 0, 3, 0x67, 1], false),
            (&[], false),
        ];
        let h265: [(&[u8], bool); 4] = [
            (&[0x62, 1, 0x93], false),
            (&[0x62, 1, 0x93, 1], true),
            (&[0x60, 1, 0, 3, 0x40, 1, 1], true),
            (&[0x60, 1, 0, 2, 0x40, 1], false),
        ];
        for (payload, is_sound) in h264 {
            assert_eq!(Nal::H264.is_sound(payload), is_sound, "{payload:?}");
        }
        for (payload, is_sound) in h265 {
            assert_eq!(Nal::H265.is_sound(payload), is_sound, "{payload:?}");
        }
    }

    #[test]
    fn only_what_stands_between_slices_of_one_picture_is_replaced() {
        let cases = [
            (Nal::H264, vec![vec![0x67, 1], vec![0x68, 1], vec![0x7c, 0x85]], vec![0x67, 1], 0x6c),
            (Nal::H264, vec![vec![0x65, 1]], vec![0x68, 1], 0x6c),
            (Nal::H265, vec![vec![0x40, 1, 1], vec![0x26, 1, 1]], vec![0x42, 1, 1], 0x4c),
            (Nal::H265, vec![vec![0x62, 1, 0x93]], vec![0x44, 1, 1], 0x4c),
        ];
        for (nal, before, repeated, filler) in cases {
            let mut sets = RepeatedSets::new(nal);
            assert!(before.iter().all(|payload| sets.on_packet(5, payload).is_none()));
            assert_eq!(sets.on_packet(5, &repeated), Some(filler));
            assert_eq!(sets.on_packet(6, &repeated), None);
        }
    }
}
