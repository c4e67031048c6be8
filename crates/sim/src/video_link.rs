//! What befalls the video between the camera and the pilot: it comes late, now and then not at all, or frozen.
//!
//! A picture takes a fixed time and a little more by chance (the sum of two exponential times). The link is good or
//! bad (`gilbert1960`, `elliott1963`), and changes from picture to picture; while it is bad a share of the pictures
//! does not come, or the decoder shows the one before in its place. Pictures never overtake each other.

use crate::random::{CounterRng, Stream};

/// How the video comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VideoLinkModel {
    /// What every picture takes at least, seconds.
    pub latency_s: f64,
    /// Mean of each of the two exponential times on top of it, seconds.
    pub jitter_s: f64,
    /// Chance, from picture to picture, that a good link becomes bad, and a bad one good.
    pub good_to_bad: f64,
    /// See `good_to_bad`.
    pub bad_to_good: f64,
    /// Share of the pictures of a bad link that are spoilt.
    pub impaired_share: f64,
    /// Share of those that show the picture before; the others do not come.
    pub frozen_share: f64,
}

impl VideoLinkModel {
    /// Every picture comes after the same time.
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

/// What befalls a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delivery {
    /// It arrives at this tick.
    Arrives {
        /// The tick.
        at: u64,
    },
    /// At this tick a picture arrives that shows what the one before showed.
    Frozen {
        /// The tick.
        at: u64,
    },
    /// It never arrives.
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

    /// What befalls the next picture, taken at `tick`.
    pub fn send(&mut self, tick: u64) -> Delivery {
        let sample = |which: u64| self.rng.unit(8 * self.pictures + which);
        let flips = sample(0) < if self.is_bad { self.script.bad_to_good } else { self.script.good_to_bad };
        let is_bad = self.is_bad != flips;
        let is_impaired = is_bad && sample(1) < self.script.impaired_share;
        let is_frozen = sample(2) < self.script.frozen_share;
        let late = |which: u64| self.script.jitter_s * self.rng.exponential(8 * self.pictures + which);
        let delay_s = self.script.latency_s + late(3) + late(4);
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
