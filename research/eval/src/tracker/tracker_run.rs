//! One run of a tracker over one clip, with its CPU time.

use std::time::Duration;

use barrelman_vision::{SelectionError, Tracker};
use barrelman_vocab::{PixelBox, Track};
use rustix::time::{ClockId, clock_gettime};

use super::clips::Clip;
use super::scoring::{Score, score_boxes};

/// The output of a tracker for a clip.
pub(crate) struct TrackerRun {
    /// One for each tracked frame; all unseeded where the selection was refused.
    pub(crate) tracks: Vec<Track>,
    /// CPU time of each tracked frame; empty where the selection was refused.
    pub(crate) cpu_times: Vec<Duration>,
    /// Why the selection was refused.
    pub(crate) selection_error: Option<SelectionError>,
}

impl TrackerRun {
    /// The reported boxes: both tracking and coasting count as reported.
    pub(crate) fn boxes(&self) -> Vec<Option<PixelBox>> {
        self.tracks.iter().map(|track| track.localisation().map(|localisation| localisation.bounds)).collect()
    }

    /// CPU time of each frame, milliseconds.
    pub(crate) fn cpu_ms(&self) -> Vec<f64> {
        self.cpu_times.iter().map(|time| time.as_secs_f64() * 1e3).collect()
    }

    /// The agreement with the clip's labels.
    pub(crate) fn score(&self, clip: &Clip) -> Score {
        score_boxes(clip.tracked_labels(), &self.boxes(), clip.size())
    }
}

/// Runs a tracker over a clip, from a selection in the clip's first frame on.
pub(crate) fn run_tracker(tracker: &mut dyn Tracker, clip: &Clip, selection: PixelBox) -> TrackerRun {
    let frames = clip.tracked_frames();
    let mut run =
        TrackerRun { tracks: Vec::with_capacity(frames.len()), cpu_times: Vec::new(), selection_error: None };
    if let Err(error) = tracker.select(&clip.frames[clip.start], selection) {
        run.tracks.resize(frames.len(), Track::Unseeded);
        run.selection_error = Some(error);
        return run;
    }
    run.cpu_times.reserve(frames.len());
    for frame in frames {
        let before = process_cpu_time();
        let track = tracker.track(frame, None);
        run.cpu_times.push(process_cpu_time().saturating_sub(before));
        run.tracks.push(track);
    }
    run
}

/// CPU time of all threads of this process: no other thread works while a tracker is timed.
pub(crate) fn process_cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // CPU time counts from zero: neither part is ever negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// The name of a track's state, for a file.
pub(crate) const fn state_name(track: &Track) -> &'static str {
    match track {
        Track::Unseeded => "unseeded",
        Track::Tracking(_) => "tracking",
        Track::Coasting(_) => "coasting",
        Track::Lost { .. } => "lost",
    }
}

/// A track's confidence; `None` where it is unseeded.
pub(crate) fn confidence(track: &Track) -> Option<f64> {
    match track {
        Track::Unseeded => None,
        Track::Tracking(localisation) | Track::Coasting(localisation) => Some(localisation.confidence),
        Track::Lost { confidence, .. } => Some(*confidence),
    }
}

/// A box for a file: left, top, width, height.
pub(crate) const fn box_numbers(bounds: PixelBox) -> [f64; 4] {
    [bounds.u, bounds.v, bounds.w, bounds.h]
}
