//! What `track` says of a track: the figures of `--json`, the summary in words, and warnings about a
//! selection.

use std::time::Duration;

use barrelman_vision::SelectionReport;
use barrelman_vocab::{PictureSize, PixelBox, Track};
use serde::Serialize;

/// A selection narrower or lower than this gives the tracker little to follow, pixels.
const SMALL_SELECTION: (f64, f64) = (12.0, 9.0);

/// Counts of a track, frame by frame.
#[derive(Debug, Default)]
pub(super) struct TrackTotals {
    tracking: u64,
    coasting: u64,
    lost: u64,
    /// Sum of the confidences of the frames that are tracked.
    confidence: f64,
    tracker_times: Vec<Duration>,
}

impl TrackTotals {
    /// Adds a frame. `time`: the tracker's; `None` for the frame of the selection.
    pub(super) fn add(&mut self, track: &Track, time: Option<Duration>) {
        match track {
            Track::Tracking(seen) => {
                self.tracking += 1;
                self.confidence += seen.confidence;
            }
            Track::Coasting(_) => self.coasting += 1,
            Track::Lost { .. } => self.lost += 1,
            Track::Unseeded => {}
        }
        self.tracker_times.extend(time);
    }

    /// The figures, with the times of the decoder.
    pub(super) fn into_figures(
        self,
        tracker: &'static str,
        damaged: u64,
        decode: Vec<Duration>,
    ) -> TrackFigures {
        TrackFigures {
            frames: self.tracking + self.coasting + self.lost,
            tracked_frames: self.tracking,
            lost_frames: self.lost,
            coasting_frames: self.coasting,
            damaged_pictures: damaged,
            mean_confidence: (self.tracking > 0).then(|| self.confidence / self.tracking as f64),
            tracker,
            tracker_cpu_ms: Percentiles::from_times(self.tracker_times),
            decode_cpu_ms: Percentiles::from_times(decode),
        }
    }
}

/// The document of `track --json`.
#[derive(Debug, Serialize)]
pub(super) struct TrackFigures {
    frames: u64,
    tracked_frames: u64,
    lost_frames: u64,
    coasting_frames: u64,
    damaged_pictures: u64,
    /// Mean confidence of the frames that are tracked; `null` where none is.
    mean_confidence: Option<f64>,
    tracker: &'static str,
    tracker_cpu_ms: Percentiles,
    decode_cpu_ms: Percentiles,
}

/// Median and 99th percentile, milliseconds; `null` without values.
#[derive(Debug, Serialize)]
struct Percentiles {
    median: Option<f64>,
    p99: Option<f64>,
}

impl Percentiles {
    fn from_times(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let percentile = |share: f64| {
            let index = (times.len().checked_sub(1)? as f64 * share).round() as usize;
            Some(times[index].as_secs_f64() * 1e3)
        };
        Self { median: percentile(0.5), p99: percentile(0.99) }
    }
}

impl TrackFigures {
    /// The track in one sentence, with the files that were written.
    pub(super) fn summary(&self, files: &[String]) -> String {
        let Self { frames, tracked_frames, coasting_frames, lost_frames, .. } = self;
        let mut text = format!(
            "{frames} frames: {tracked_frames} tracked, {coasting_frames} coasting, {lost_frames} lost"
        );
        if let Some(confidence) = self.mean_confidence {
            text += &format!("; mean confidence {confidence:.2}");
        }
        if let Some(median) = self.tracker_cpu_ms.median {
            text += &format!("; {median:.1} ms a frame");
        }
        if !files.is_empty() {
            text += &format!("; written: {}", files.join(", "));
        }
        text
    }

    /// Whether the target was lost for most of the video.
    pub(super) fn is_mostly_lost(&self) -> bool {
        2 * self.lost_frames > self.frames
    }
}

/// What is doubtful about a selection that the tracker took.
pub(super) fn selection_warnings(
    selection: PixelBox,
    report: &SelectionReport,
    picture: PictureSize,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if report.is_clipped {
        let right = (selection.u + selection.w).min(f64::from(picture.width)) - selection.u.max(0.0);
        let bottom = (selection.v + selection.h).min(f64::from(picture.height)) - selection.v.max(0.0);
        let inside = (right * bottom) / (selection.w * selection.h);
        warnings.push(format!(
            "{:.0} % of the selection {selection} lies outside the {picture} picture: the tracker learns {} alone; select \
             on a frame that shows the whole boat (--start-frame)",
            100.0 * (1.0 - inside),
            report.used
        ));
    }
    let (width, height) = SMALL_SELECTION;
    if selection.w < width || selection.h < height {
        warnings.push(format!(
            "the selection {selection} is small: a box of less than {width} x {height} pixels holds little to follow; draw \
             the box around the whole boat, or use a larger picture"
        ));
    }
    warnings
}
