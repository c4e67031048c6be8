//! What one reader gets. A plain state machine: no clock, no socket, no GStreamer.
//!
//! ```text
//!  Describing --key--> Held --PLAY--> Joining --key--> Following --stuck--> Behind
//!                       ^  <--PAUSE-- (any)    ^                              |
//!                                              '--------- takes again --------'
//! ```
//! A reader that does not take its units in time loses units up to a key frame: it is never further behind
//! than what its socket holds.

use std::time::{Duration, Instant};

use barrelman_media_protocol::share::Demand;

/// How long a socket may be full before units are left out. A key frame fills a slow line's socket for a
/// while.
const PATIENCE: Duration = Duration::from_millis(250);

/// How far a reader is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reader {
    /// Asked for a description, which tells the parameter sets of a key frame.
    Describing,
    /// Has the key frame of its description, and does not play.
    Held,
    /// Plays from the next key frame on.
    Joining,
    /// Gets every unit. `full_since`: its socket takes nothing.
    Following { full_since: Option<Instant> },
    /// Loses units until its socket takes some again.
    Behind,
}

impl Reader {
    /// Whether the reader gets a unit. `takes`: there is room in its socket.
    pub(super) fn offer(&mut self, is_key: bool, takes: bool, now: Instant) -> bool {
        let (next, gets) = match *self {
            Self::Describing if is_key => (Self::Held, true),
            Self::Joining if is_key => (Self::Following { full_since: None }, true),
            Self::Following { .. } if takes => (Self::Following { full_since: None }, true),
            Self::Following { full_since } => {
                let since = full_since.unwrap_or(now);
                if now.saturating_duration_since(since) < PATIENCE {
                    (Self::Following { full_since: Some(since) }, true)
                } else {
                    (Self::Behind, false)
                }
            }
            Self::Behind if takes && is_key => (Self::Following { full_since: None }, true),
            Self::Behind if takes => (Self::Joining, false),
            waiting @ (Self::Describing | Self::Held | Self::Joining | Self::Behind) => (waiting, false),
        };
        *self = next;
        gets
    }

    pub(super) const fn play(&mut self) {
        *self = Self::Joining;
    }

    pub(super) const fn pause(&mut self) {
        *self = Self::Held;
    }

    pub(super) const fn demand(self) -> Demand {
        match self {
            Self::Held => Demand::Nothing,
            // A reader that is behind looks at each unit whether its socket takes some again.
            Self::Following { .. } | Self::Behind => Demand::Units,
            Self::Describing | Self::Joining => Demand::KeyFrame,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: bool = true;
    const OTHER: bool = false;

    /// Offers units, each 40 ms after the one before it, and returns which the reader gets.
    fn offered(reader: &mut Reader, start: Instant, units: &[(bool, bool)]) -> Vec<bool> {
        let at = |index: usize| start + Duration::from_millis(40) * index as u32;
        units.iter().enumerate().map(|(index, (key, takes))| reader.offer(*key, *takes, at(index))).collect()
    }

    #[test]
    fn a_reader_gets_a_key_frame_for_its_description_and_plays_from_another_on() {
        let (mut reader, start) = (Reader::Describing, Instant::now());
        assert_eq!(
            offered(&mut reader, start, &[(OTHER, true), (KEY, true), (KEY, true)]),
            [false, true, false]
        );
        assert_eq!((reader, reader.demand()), (Reader::Held, Demand::Nothing));
        reader.play();
        assert_eq!(reader.demand(), Demand::KeyFrame);
        assert_eq!(
            offered(&mut reader, start, &[(OTHER, true), (KEY, true), (OTHER, true)]),
            [false, true, true]
        );
        assert_eq!(reader.demand(), Demand::Units);
        reader.pause();
        assert_eq!(offered(&mut reader, start, &[(KEY, true)]), [false]);
    }

    #[test]
    fn a_reader_that_takes_nothing_loses_units_up_to_a_key_frame() {
        let (mut reader, start) = (Reader::Following { full_since: None }, Instant::now());
        let full = [(OTHER, false); 10];
        let got = offered(&mut reader, start, &full);
        assert_eq!(got.iter().filter(|got| **got).count(), 7, "those of {PATIENCE:?}");
        assert_eq!(reader, Reader::Behind);
        assert_eq!(offered(&mut reader, start, &[(KEY, false), (OTHER, true)]), [false, false]);
        assert_eq!(reader.demand(), Demand::KeyFrame);
        assert_eq!(offered(&mut reader, start, &[(OTHER, true), (KEY, true)]), [false, true]);
    }

    #[test]
    fn a_socket_that_is_full_for_a_moment_costs_nothing() {
        let (mut reader, start) = (Reader::Following { full_since: None }, Instant::now());
        let units = [(KEY, true), (OTHER, false), (OTHER, false), (OTHER, true)].repeat(5);
        assert!(offered(&mut reader, start, &units).iter().all(|got| *got));
    }
}
