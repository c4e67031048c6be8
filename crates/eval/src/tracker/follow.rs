//! One run of a tracker over one clip, and what it cost.

use std::time::Duration;

use barrelman_vision::{SelectionError, Tracker};
use barrelman_vocab::{PixelBox, Track, VideoFrame};
use rustix::time::{ClockId, clock_gettime};

use super::clips::Clip;
use super::scoring::{Score, score};

/// What a tracker said, and what it took.
pub(crate) struct Followed {
    /// One for each frame after the selection's; all unseeded where the selection was refused.
    pub(crate) tracks: Vec<Track>,
    /// CPU time of each.
    pub(crate) cpu: Vec<Duration>,
    /// Why the selection was refused.
    pub(crate) refused: Option<SelectionError>,
}

impl Followed {
    /// The reported boxes: tracking and coasting both count.
    pub(crate) fn boxes(&self) -> Vec<Option<PixelBox>> {
        self.tracks.iter().map(|track| track.localisation().map(|seen| seen.bounds)).collect()
    }

    /// CPU milliseconds of each frame.
    pub(crate) fn cpu_ms(&self) -> Vec<f64> {
        self.cpu.iter().map(|time| time.as_secs_f64() * 1e3).collect()
    }

    /// How well they agree with the clip's labels.
    pub(crate) fn score(&self, clip: &Clip) -> Score {
        score(clip.tracked_labels(), &self.boxes(), clip.size())
    }
}

/// Shows a tracker the clip's frames from its start on.
pub(crate) fn follow(tracker: &mut dyn Tracker, clip: &Clip, selection: PixelBox) -> Followed {
    follow_frames(tracker, &clip.frames[clip.start], clip.tracked(), selection)
}

/// Shows a tracker a selection, and then frames.
pub(crate) fn follow_frames(
    tracker: &mut dyn Tracker,
    first: &VideoFrame,
    frames: &[VideoFrame],
    selection: PixelBox,
) -> Followed {
    let mut followed = Followed { tracks: Vec::with_capacity(frames.len()), cpu: Vec::new(), refused: None };
    if let Err(refused) = tracker.select(first, selection) {
        followed.tracks.resize(frames.len(), Track::Unseeded);
        followed.refused = Some(refused);
        return followed;
    }
    followed.cpu.reserve(frames.len());
    for frame in frames {
        let before = cpu_time();
        let track = tracker.track(frame, None);
        followed.cpu.push(cpu_time().saturating_sub(before));
        followed.tracks.push(track);
    }
    followed
}

/// CPU time of all threads of this program: nothing else runs in it while a tracker is timed.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // CPU time counts from zero: neither part is ever negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// The state's name, for a file.
pub(crate) const fn state_of(track: &Track) -> &'static str {
    match track {
        Track::Unseeded => "unseeded",
        Track::Tracking(_) => "tracking",
        Track::Coasting(_) => "coasting",
        Track::Lost { .. } => "lost",
    }
}

/// The confidence, where there is one.
pub(crate) fn confidence_of(track: &Track) -> Option<f64> {
    match track {
        Track::Unseeded => None,
        Track::Tracking(seen) | Track::Coasting(seen) => Some(seen.confidence),
        Track::Lost { confidence, .. } => Some(*confidence),
    }
}

/// A box for a file: left, top, width, height.
pub(crate) const fn corners(bounds: PixelBox) -> [f64; 4] {
    [bounds.u, bounds.v, bounds.w, bounds.h]
}
