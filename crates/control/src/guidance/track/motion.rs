//! The boat's motion by the vessel's model: each state follows from the one before and the command in force.

use crate::ring::Ring;

/// Stored states of the model; at [`MIN_INTERVAL_S`] they cover 2 s.
pub(super) const HISTORY_LEN: usize = 128;
/// Shortest interval between two stored states, seconds.
pub(super) const MIN_INTERVAL_S: f64 = 0.016;

/// State of the vessel's model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub(super) at_s: f64,
    /// Integral of the turn rate of the course, radians.
    pub(super) turned: f64,
    /// Turn rate of the bow, and of the course, rad/s.
    pub(super) yaw: f64,
    pub(super) turn: f64,
    pub(super) thrust: f64,
    /// Speed through the water, m/s.
    pub(super) surge: f64,
    /// Place in still water, along the axes of the first course, metres.
    pub(super) way: (f64, f64),
}

/// The integral of the turn rate at a time, radians.
pub(super) fn turned_at(motion: &Ring<Motion, HISTORY_LEN>, at_s: f64) -> f64 {
    motion_at(motion, at_s).turned
}

/// The interpolated state of the model at a time; the newest or the oldest stored state beyond the history.
pub(super) fn motion_at(motion: &Ring<Motion, HISTORY_LEN>, at_s: f64) -> Motion {
    let mut later = motion.newest();
    if at_s >= later.at_s {
        return *later;
    }
    for earlier in motion.earlier() {
        if earlier.at_s <= at_s {
            if earlier.at_s == f64::NEG_INFINITY {
                break;
            }
            let share = (at_s - earlier.at_s) / (later.at_s - earlier.at_s);
            let mix = |a: f64, b: f64| a + share * (b - a);
            return Motion {
                at_s,
                turned: mix(earlier.turned, later.turned),
                yaw: mix(earlier.yaw, later.yaw),
                turn: mix(earlier.turn, later.turn),
                thrust: mix(earlier.thrust, later.thrust),
                surge: mix(earlier.surge, later.surge),
                way: (mix(earlier.way.0, later.way.0), mix(earlier.way.1, later.way.1)),
            };
        }
        later = earlier;
    }
    *later
}
