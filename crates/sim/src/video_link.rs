//! What befalls the video between the camera and the pilot: it comes late, now and then not at all, or frozen.
//!
//! A picture takes a fixed time and a little more by chance (the sum of two exponential times). The link is good or
//! bad (`gilbert1960`, `elliott1963`), and changes from picture to picture; while it is bad a share of the pictures
//! does not come, or the decoder shows the one before in its place. Pictures never overtake each other.

use crate::chance::{Draws, Stream};

/// How the video comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VideoLinkScript {
    /// What every picture takes at least, seconds.
    pub latency_s: f64,
    /// Mean of each of the two exponential times on top of it, seconds.
    pub jitter_s: f64,
    /// Chance, from picture to picture, that a good link becomes bad, and a bad one good.
    pub to_bad: f64,
    /// See `to_bad`.
    pub to_good: f64,
    /// Share of the pictures of a bad link that are spoilt.
    pub spoilt: f64,
    /// Share of those that show the picture before; the others do not come.
    pub frozen: f64,
}

impl VideoLinkScript {
    /// Every picture comes after the same time.
    pub const fn steady(latency_s: f64) -> Self {
        Self { latency_s, jitter_s: 0.0, to_bad: 0.0, to_good: 1.0, spoilt: 0.0, frozen: 0.0 }
    }
}

/// What befalls a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passage {
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
    script: VideoLinkScript,
    draws: Draws,
    is_bad: bool,
    pictures: u64,
    last_arrival: u64,
}

impl VideoLink {
    /// A good link.
    pub const fn new(script: VideoLinkScript, seed: u64) -> Self {
        Self {
            script,
            draws: Draws::of(seed, Stream::VideoLink),
            is_bad: false,
            pictures: 0,
            last_arrival: 0,
        }
    }

    /// What befalls the next picture, taken at `tick`.
    pub fn send(&mut self, tick: u64) -> Passage {
        let draw = |which: u64| self.draws.unit(8 * self.pictures + which);
        let flips = draw(0) < if self.is_bad { self.script.to_good } else { self.script.to_bad };
        let is_bad = self.is_bad != flips;
        let is_spoilt = is_bad && draw(1) < self.script.spoilt;
        let is_frozen = draw(2) < self.script.frozen;
        let late = |which: u64| self.script.jitter_s * self.draws.exponential(8 * self.pictures + which);
        let delay_s = self.script.latency_s + late(3) + late(4);
        let delay = (delay_s * f64::from(crate::camera_axis::TICKS_PER_SECOND) + 0.5) as u64;
        let at = (tick + delay).max(self.last_arrival);
        (self.is_bad, self.pictures) = (is_bad, self.pictures + 1);
        if is_spoilt && !is_frozen {
            return Passage::Lost;
        }
        self.last_arrival = at;
        if is_spoilt { Passage::Frozen { at } } else { Passage::Arrives { at } }
    }
}
