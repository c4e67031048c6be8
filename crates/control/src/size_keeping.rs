//! The zoom that keeps the target's size in the picture within a range.
//!
//! The size is the longer side of the target's box as a share of the picture's height. The zoom rests while
//! the size is within the range. A movement goes on until the size is well within the range, so that each
//! excursion is one movement:
//!
//! ```text
//!              below the range, and all is well                 above the range
//!   Closer <------------------------------------- Resting -----------------------> Wider
//!      +---- well within, or not all is well --------> ^ <------ well within ----------+
//! ```
//!
//! A boat that is seen from its stern looks shorter than it is. So the target is too small where the largest
//! size lately is, and too large where the present size is. All is well while the target is measured for a
//! while with confidence, well within the region, which it has not left lately. In doubt about a target near
//! the region's border, and where the target leaves the region, the view widens at once. A destination that
//! is to be shown, too, widens the view while the target is larger than the smallest size.
//!
//! Input: what was measured of the target in a frame. Must not be here: whether the camera may move.

use core::time::Duration;

use barrelman_vocab::profile::SizeKeeping;
use barrelman_vocab::{Timestamp, ZoomDynamics, ZoomRate};

/// Rate at which the view becomes closer: slow, so that the target and its surroundings stay recognisable.
const CLOSER: ZoomRate = ZoomRate::from_per_second(0.15);
/// Rate at which the view becomes wider where the target is too large.
const WIDER: ZoomRate = ZoomRate::from_per_second(-0.2);
/// The view becomes closer only after the target was sure for this time.
const SURE_FOR: Duration = Duration::from_secs(1);
/// Least confidence of a target that is sure.
const SURE: f64 = 0.7;
/// Below this confidence there is doubt.
const DOUBT: f64 = 0.5;
/// The view begins to become closer up to this P, and goes on up to the other one: a closer view moves the
/// target outwards.
const CLOSER_P: (f64, f64) = (0.7, 0.85);
/// From this P on the target is near the border of the region.
const BORDER_P: f64 = 0.5;
/// From this P on the view becomes wider: the target is too fast for so close a view.
const OUTSIDE_P: f64 = 1.05;
/// The view becomes closer only this long after the target was outside of the region.
const AFTER_OUTSIDE: Duration = Duration::from_secs(8);
/// A destination that is to be shown widens the view from the second of these shares of half the picture on
/// until it is within the first; only within the first does the view become closer.
const DESTINATION_SHARES: (f64, f64) = (0.8, 0.95);
/// A movement goes on until the size is this factor within the range.
const GOAL: f64 = 1.5;
/// Time constant of the smoothed size, seconds: longer than the boat rolls, shorter than it approaches.
const SMOOTHING_S: f64 = 0.5;
/// Decay of the logarithm of the largest size lately, per second: slower than a boat that turns looks
/// shorter, faster than one that goes away.
const DECAY_PER_S: f64 = 0.07;

/// What was measured of the target in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeInput {
    /// The longer side of the target's box over the picture's height.
    pub size: f64,
    /// P of the target's position.
    pub p: f64,
    /// How far from the middle of the picture the destination is that is to be shown, too: the larger share
    /// of half its width or height, above 1 outside of the picture. 0: none is to be shown.
    pub destination_share: f64,
    /// Whether the target was measured in this frame; otherwise its position is predicted.
    pub is_measured: bool,
    /// The tracker's confidence, 0 to 1.
    pub confidence: f64,
    /// Focal length at the time of capture, and now, as shares of the picture's width.
    pub focal_shares: (f64, f64),
    /// Time of capture.
    pub captured: Timestamp,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Movement {
    Resting,
    Closer,
    Wider,
}

/// Keeps the size of one target.
#[derive(Debug, Clone)]
pub struct SizeKeeper {
    range: SizeKeeping,
    zoom: ZoomDynamics,
    /// Focal length of the widest view, as a share of the picture's width.
    widest_share: f64,
    movement: Movement,
    sure_since: Option<Timestamp>,
    /// When the target was outside of the region last.
    outside_at: Option<Timestamp>,
    size: Option<MeasuredSize>,
}

/// The size of the target at a focal length of 1: logarithms.
#[derive(Debug, Clone, Copy)]
struct MeasuredSize {
    smoothed: f64,
    /// The largest one lately.
    largest: f64,
    /// When it was measured.
    at: Timestamp,
}

/// The size of the target at the present focal length.
#[derive(Debug, Clone, Copy)]
struct PresentSize {
    smoothed: f64,
    largest: f64,
}

impl SizeKeeper {
    /// A keeper of sizes within `range`, for a zoom with its widest view.
    pub const fn new(range: SizeKeeping, zoom: ZoomDynamics, widest_share: f64) -> Self {
        Self {
            range,
            zoom,
            widest_share,
            movement: Movement::Resting,
            sure_since: None,
            outside_at: None,
            size: None,
        }
    }

    /// Forgets the target.
    pub fn reset_target(&mut self) {
        (self.movement, self.sure_since, self.size) = (Movement::Resting, None, None);
    }

    /// The rate of the zoom for a frame. A target that is not localised needs none.
    pub fn rate(&mut self, input: &SizeInput) -> ZoomRate {
        let is_sure = input.is_measured && input.confidence >= SURE;
        let since = self.sure_since.filter(|since| is_sure && *since <= input.captured);
        self.sure_since = since.or_else(|| is_sure.then_some(input.captured));
        let is_in_doubt = !input.is_measured || input.confidence < DOUBT;
        self.outside_at = if input.p > 1.0 { Some(input.captured) } else { self.outside_at };
        if input.p > OUTSIDE_P || is_in_doubt && input.p > BORDER_P {
            self.movement = Movement::Resting;
            return self.wider_than(-self.zoom.max_rate, input);
        }
        let Some(PresentSize { smoothed: size, largest }) = self.measured(input) else {
            return ZoomRate::ZERO;
        };
        let (least, most) = (GOAL * self.range.smallest, self.range.largest / GOAL);
        let was_outside = self.outside_at.is_some_and(|at| input.captured.since(at) < AFTER_OUTSIDE);
        let (inside, border) = DESTINATION_SHARES;
        let is_well = |largest_p: f64| {
            is_sure && !was_outside && input.p <= largest_p && input.destination_share <= inside
        };
        let has_been_sure = self.sure_since.is_some_and(|since| input.captured.since(since) >= SURE_FOR);
        let shows_more = size > least;
        self.movement = match self.movement {
            _ if size > self.range.largest => Movement::Wider,
            _ if shows_more && input.destination_share > border => Movement::Wider,
            Movement::Wider if size > most => Movement::Wider,
            Movement::Wider if shows_more && input.destination_share > inside => Movement::Wider,
            Movement::Closer if largest < least && is_well(CLOSER_P.1) => Movement::Closer,
            _ if largest < self.range.smallest && has_been_sure && is_well(CLOSER_P.0) => Movement::Closer,
            Movement::Resting | Movement::Wider | Movement::Closer => Movement::Resting,
        };
        match self.movement {
            Movement::Resting => ZoomRate::ZERO,
            Movement::Closer if input.focal_shares.1 >= self.zoom.ratio * self.widest_share => ZoomRate::ZERO,
            Movement::Closer => CLOSER.clamped(self.zoom.max_rate),
            Movement::Wider => self.wider_than(WIDER.clamped(self.zoom.max_rate), input),
        }
    }

    /// This rate, unless the view is the widest.
    fn wider_than(&self, rate: ZoomRate, input: &SizeInput) -> ZoomRate {
        if input.focal_shares.1 > self.widest_share { rate } else { ZoomRate::ZERO }
    }

    /// The size of the target at the present focal length; `None`: it was never measured.
    fn measured(&mut self, input: &SizeInput) -> Option<PresentSize> {
        let (then, now) = input.focal_shares;
        if input.is_measured && input.size > 0.0 {
            let measured = libm::log(input.size / then);
            let first = MeasuredSize { smoothed: measured, largest: measured, at: input.captured };
            self.size = Some(self.size.map_or(first, |before| {
                let interval_s = input.captured.since(before.at).as_secs_f64();
                let share = 1.0 - libm::exp(-interval_s / SMOOTHING_S);
                let smoothed = before.smoothed + share * (measured - before.smoothed);
                let largest = (before.largest - DECAY_PER_S * interval_s).max(smoothed);
                MeasuredSize { smoothed, largest, at: input.captured }
            }));
        }
        let size = self.size?;
        Some(PresentSize { smoothed: now * libm::exp(size.smoothed), largest: now * libm::exp(size.largest) })
    }
}
