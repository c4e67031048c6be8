//! The recent focal lengths of a camera with zoom.

use core::time::Duration;

use barrelman_vocab::Timestamp;

use crate::ring::Ring;

/// Number of stored focal lengths. At [`MIN_FOCAL_INTERVAL`] they cover 1.2 s of a zoom in progress.
const HISTORY_LEN: usize = 32;
/// Shortest interval between two stored focal lengths.
const MIN_FOCAL_INTERVAL: Duration = Duration::from_millis(40);

/// Focal lengths as shares of the picture's width, each with the time from which it is valid.
#[derive(Debug, Clone)]
pub(super) struct FocalHistory(Ring<(f64, Timestamp), HISTORY_LEN>);

impl FocalHistory {
    pub(super) fn new(share: f64) -> Self {
        Self(Ring::new((share, Timestamp::ZERO)))
    }

    /// Adds a focal length; one that is older than the newest is ignored.
    pub(super) fn push(&mut self, share: f64, at: Timestamp) {
        let (_, last) = *self.0.newest();
        if at >= last {
            self.0.push((share, at), |(_, previous), (_, last)| last.since(*previous) >= MIN_FOCAL_INTERVAL);
        }
    }

    /// The focal length at a time; the oldest stored one for earlier times.
    pub(super) fn at(&self, at: Timestamp) -> f64 {
        let (mut share, mut since) = *self.0.newest();
        for (earlier_share, earlier) in self.0.earlier() {
            if since <= at {
                break;
            }
            (share, since) = (*earlier_share, *earlier);
        }
        share
    }
}
