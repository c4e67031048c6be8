//! The video link between camera and pilot: latency, jitter, lost and frozen video frames.
//!
//! Each frame takes a fixed time plus the sum of two exponential times. The link is good or bad
//! (`gilbert1960`, `elliott1963`) and changes from frame to frame. While the link is bad, a share of the
//! frames is impaired: lost, or replaced by the frame before. Frames never overtake each other.

use crate::random::{CounterRng, Stream};

/// Parameters of the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VideoLinkModel {
    /// Least latency of a frame, seconds.
    pub latency_s: f64,
    /// Mean of each of the two exponential times added to the latency, seconds.
    pub jitter_s: f64,
    /// Probability, from frame to frame, that a good link becomes bad.
    pub good_to_bad: f64,
    /// Probability, from frame to frame, that a bad link becomes good.
    pub bad_to_good: f64,
    /// Share of the frames on a bad link that are impaired.
    pub impaired_share: f64,
    /// Share of the impaired frames that show the frame before; the others are lost.
    pub frozen_share: f64,
}

impl VideoLinkModel {
    /// A link with this constant latency, seconds.
    pub const fn steady(latency_s: f64) -> Self {
        Self {
            latency_s,
            jitter_s: 0.0,
            good_to_bad: 0.0,
            bad_to_good: 1.0,
            impaired_share: 0.0,
            frozen_share: 0.0,
        }
    }
}

/// What happens to a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delivery {
    /// The frame arrives.
    Arrives {
        /// Tick of arrival.
        at: u64,
    },
    /// A frame arrives that shows the content of the one before.
    Frozen {
        /// Tick of arrival.
        at: u64,
    },
    /// The frame never arrives.
    Lost,
}

/// The link of a trial.
#[derive(Debug, Clone)]
pub struct VideoLink {
    script: VideoLinkModel,
    rng: CounterRng,
    is_bad: bool,
    pictures: u64,
    last_arrival: u64,
}

impl VideoLink {
    /// A good link.
    pub const fn new(script: VideoLinkModel, seed: u64) -> Self {
        Self {
            script,
            rng: CounterRng::new(seed, Stream::VideoLink),
            is_bad: false,
            pictures: 0,
            last_arrival: 0,
        }
    }

    /// What happens to the next frame, taken at `tick`.
    pub fn send(&mut self, tick: u64) -> Delivery {
        let sample = |which: u64| self.rng.unit(8 * self.pictures + which);
        let flips = sample(0) < if self.is_bad { self.script.bad_to_good } else { self.script.good_to_bad };
        let is_bad = self.is_bad != flips;
        let is_impaired = is_bad && sample(1) < self.script.impaired_share;
        let is_frozen = sample(2) < self.script.frozen_share;
        let jitter = |which: u64| self.script.jitter_s * self.rng.exponential(8 * self.pictures + which);
        let delay_s = self.script.latency_s + jitter(3) + jitter(4);
        let delay = (delay_s * f64::from(crate::tick::TICKS_PER_SECOND) + 0.5) as u64;
        let at = (tick + delay).max(self.last_arrival);
        (self.is_bad, self.pictures) = (is_bad, self.pictures + 1);
        if is_impaired && !is_frozen {
            return Delivery::Lost;
        }
        self.last_arrival = at;
        if is_impaired { Delivery::Frozen { at } } else { Delivery::Arrives { at } }
    }
}
