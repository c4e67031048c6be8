//! One sender: packets of another one that come between would tear the pictures.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// How long a sender must be silent before another one takes its place.
pub(super) const SILENCE: Duration = Duration::from_secs(1);

/// What to do with a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It belongs to the stream.
    Accepted,
    /// It comes from another sender while the first one sends. Told once.
    Ignored { is_first: bool },
    /// The sender was silent, and another one has begun: a stream of its own.
    Replaced,
}

/// Remembers the sender that was heard first. A sender is an address and, where that is known, a
/// synchronisation source (SSRC; RFC 3550, 3). The source is known of RTP only, whose content is known.
#[derive(Debug, Default)]
pub(super) struct Gate {
    heard: Option<Heard>,
    has_ignored: bool,
}

#[derive(Debug)]
struct Heard {
    from: SocketAddr,
    ssrc: Option<u32>,
    at: Instant,
}

impl Gate {
    pub(super) fn judge(&mut self, from: SocketAddr, ssrc: Option<u32>, now: Instant) -> Verdict {
        let heard = self.heard.get_or_insert(Heard { from, ssrc, at: now });
        let has_same_source = heard.ssrc.zip(ssrc).is_none_or(|(heard, ssrc)| heard == ssrc);
        if heard.from == from && has_same_source {
            heard.at = now;
            heard.ssrc = heard.ssrc.or(ssrc);
            return Verdict::Accepted;
        }
        if now.saturating_duration_since(heard.at) >= SILENCE {
            return Verdict::Replaced;
        }
        Verdict::Ignored { is_first: !std::mem::replace(&mut self.has_ignored, true) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_sender_is_heard_after_a_silence_only() {
        let mut gate = Gate::default();
        let [first, second] = [1, 2].map(|port| SocketAddr::from(([127, 0, 0, 1], port)));
        let start = Instant::now();
        assert_eq!(gate.judge(first, Some(7), start), Verdict::Accepted);
        assert_eq!(gate.judge(second, Some(7), start), Verdict::Ignored { is_first: true });
        assert_eq!(gate.judge(first, Some(8), start), Verdict::Ignored { is_first: false });
        assert_eq!(gate.judge(first, Some(7), start + SILENCE), Verdict::Accepted);
        assert_eq!(gate.judge(second, None, start + SILENCE), Verdict::Ignored { is_first: false });
        assert_eq!(gate.judge(second, None, start + 2 * SILENCE), Verdict::Replaced);
    }

    #[test]
    fn a_source_counts_from_when_it_is_known() {
        let mut gate = Gate::default();
        let from = SocketAddr::from(([127, 0, 0, 1], 1));
        let start = Instant::now();
        for (ssrc, verdict) in [
            (None, Verdict::Accepted),
            (Some(7), Verdict::Accepted),
            (None, Verdict::Accepted),
            (Some(8), Verdict::Ignored { is_first: true }),
            (Some(7), Verdict::Accepted),
        ] {
            assert_eq!(gate.judge(from, ssrc, start), verdict, "{ssrc:?}");
        }
    }
}
