//! The metrics of a sequence in which the target leaves the picture and returns.
//!
//! An *absence* lasts from the first frame without any of the target up to the first that shows some of it.
//! The *return* is the first frame after the absence that shows at least half of the target. A frame
//! is *reported* if the track is tracking or coasting. It is *correct* if the track is tracking, and its box
//! has an IoU of at least 0.3 with the truth or its centre lies in the truth's box.

use barrelman_vocab::{PixelBox, PixelPoint, Track};

/// The target has returned when at least this share of it is visible.
const MIN_RETURNED_SHARE: f64 = 0.5;

/// A box with at least this IoU is on the target.
const MIN_CORRECT_IOU: f64 = 0.3;

/// A box with an IoU below this is not on the target.
const MIN_TARGET_IOU: f64 = 0.1;

/// For this long after the target has left it may still be reported, seconds.
pub(crate) const GRACE_S: f64 = 0.5;

/// A target must be found within this time after its return, seconds.
pub(crate) const MAX_FIND_S: f64 = 1.0;

/// The truth of a frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FrameTruth {
    /// Time of capture, seconds from the sequence's start.
    pub(crate) time_s: f64,
    /// The part of the target's box in the picture; empty where the target is absent.
    pub(crate) bounds: PixelBox,
    /// Share of the target in the picture, 0 to 1.
    pub(crate) visible_share: f64,
    /// Boxes of the distractors in the picture.
    pub(crate) distractors: Vec<PixelBox>,
}

/// The metrics of one sequence, or of several.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct AbsenceMetrics {
    /// Frames without the target.
    pub(crate) absent: usize,
    /// Of those, the frames later than [`GRACE_S`] after the target left.
    pub(crate) absent_late: usize,
    /// Of those, the reported frames.
    pub(crate) absent_late_reported: usize,
    /// For each absence, the time until the target was first not reported, seconds; the duration of the
    /// absence where it was always reported.
    pub(crate) lost_after_s: Vec<f64>,
    /// For each return, the time until the first correct frame, seconds; `None` where that took longer than
    /// [`MAX_FIND_S`].
    pub(crate) found_after_s: Vec<Option<f64>>,
    /// Longest uninterrupted time on a distractor, seconds.
    pub(crate) on_distractor_s: f64,
    /// Frames that show at least half of the target.
    pub(crate) shown: usize,
    /// Of those, the correct frames.
    pub(crate) shown_correct: usize,
}

impl AbsenceMetrics {
    /// Adds the metrics of other sequences.
    pub(crate) fn add(&mut self, other: &Self) {
        self.absent += other.absent;
        self.absent_late += other.absent_late;
        self.absent_late_reported += other.absent_late_reported;
        self.lost_after_s.extend(&other.lost_after_s);
        self.found_after_s.extend(&other.found_after_s);
        self.on_distractor_s = self.on_distractor_s.max(other.on_distractor_s);
        self.shown += other.shown;
        self.shown_correct += other.shown_correct;
    }

    /// Share of the late absent frames that were reported; 0 where there are none.
    pub(crate) fn late_reported_share(&self) -> f64 {
        self.absent_late_reported as f64 / self.absent_late.max(1) as f64
    }

    /// The number of returns after which the target was found in time.
    pub(crate) fn found_returns(&self) -> usize {
        self.found_after_s.iter().flatten().count()
    }

    /// The longest time until a target was first not reported, seconds.
    pub(crate) fn slowest_loss_s(&self) -> f64 {
        self.lost_after_s.iter().copied().fold(0.0, f64::max)
    }
}

/// Measures the frames of a sequence, in order, without the selection's.
pub(crate) fn measure(frames: &[(FrameTruth, Track)]) -> AbsenceMetrics {
    let mut metrics = AbsenceMetrics::default();
    for absence in absences(frames) {
        measure_absence(&frames[absence.clone()], &mut metrics);
        measure_return(&frames[absence.end..], &mut metrics);
    }
    for (truth, track) in frames.iter().filter(|(truth, _)| truth.visible_share >= MIN_RETURNED_SHARE) {
        metrics.shown += 1;
        metrics.shown_correct += usize::from(is_correct(truth, track));
    }
    metrics.on_distractor_s = longest_on_distractor_s(frames);
    metrics
}

/// The ranges of frames without the target.
fn absences(frames: &[(FrameTruth, Track)]) -> Vec<std::ops::Range<usize>> {
    let mut absences = Vec::new();
    let mut from = 0;
    for part in frames.chunk_by(|(a, _), (b, _)| (a.visible_share <= 0.0) == (b.visible_share <= 0.0)) {
        if part[0].0.visible_share <= 0.0 {
            absences.push(from..from + part.len());
        }
        from += part.len();
    }
    absences
}

fn measure_absence(frames: &[(FrameTruth, Track)], metrics: &mut AbsenceMetrics) {
    let left_s = frames[0].0.time_s;
    metrics.absent += frames.len();
    for (_, track) in frames.iter().filter(|(truth, _)| truth.time_s - left_s > GRACE_S) {
        metrics.absent_late += 1;
        metrics.absent_late_reported += usize::from(track.localisation().is_some());
    }
    let lost = frames.iter().find(|(_, track)| track.localisation().is_none());
    let last_s = frames[frames.len() - 1].0.time_s;
    metrics.lost_after_s.push(lost.map_or(last_s, |(truth, _)| truth.time_s) - left_s);
}

/// Measures the return after an absence; `frames` begin at the end of the absence.
fn measure_return(frames: &[(FrameTruth, Track)], metrics: &mut AbsenceMetrics) {
    // A target that shows less than half and leaves again has not returned.
    let until = frames.iter().position(|(truth, _)| truth.visible_share <= 0.0).unwrap_or(frames.len());
    let frames = &frames[..until];
    let Some(returned) = frames.iter().position(|(truth, _)| truth.visible_share >= MIN_RETURNED_SHARE)
    else {
        return;
    };
    let frames = &frames[returned..];
    let since_s = frames[0].0.time_s;
    let found = frames
        .iter()
        .find(|(truth, track)| is_correct(truth, track))
        .map(|(truth, _)| truth.time_s - since_s);
    metrics.found_after_s.push(found.filter(|after_s| *after_s <= MAX_FIND_S));
}

/// Whether a frame is correct. Coasting is a prediction and does not count.
fn is_correct(truth: &FrameTruth, track: &Track) -> bool {
    let Track::Tracking(localisation) = track else { return false };
    localisation.bounds.iou(truth.bounds) >= MIN_CORRECT_IOU
        || contains(truth.bounds, localisation.bounds.centre())
}

fn is_on_distractor(truth: &FrameTruth, track: &Track) -> bool {
    let Some(localisation) = track.localisation() else { return false };
    let centre = localisation.bounds.centre();
    localisation.bounds.iou(truth.bounds) < MIN_TARGET_IOU
        && truth.distractors.iter().any(|distractor| contains(*distractor, centre))
}

/// The longest uninterrupted time on a distractor, seconds. A frame lasts until the next.
fn longest_on_distractor_s(frames: &[(FrameTruth, Track)]) -> f64 {
    let mut longest_s = 0.0_f64;
    let mut since_s = None;
    for (index, (truth, track)) in frames.iter().enumerate() {
        if !is_on_distractor(truth, track) {
            since_s = None;
            continue;
        }
        let since_s = *since_s.get_or_insert(truth.time_s);
        let until_s = match frames.get(index + 1) {
            Some((next, _)) => next.time_s,
            None => truth.time_s,
        };
        longest_s = longest_s.max(until_s - since_s);
    }
    longest_s
}

fn contains(bounds: PixelBox, point: PixelPoint) -> bool {
    !bounds.is_empty()
        && (bounds.u..bounds.u + bounds.w).contains(&point.u)
        && (bounds.v..bounds.v + bounds.h).contains(&point.v)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{Localisation, PictureSize, Timestamp};

    use super::*;

    const TARGET: PixelBox = PixelBox { u: 10.0, v: 10.0, w: 20.0, h: 10.0 };
    const OTHER: PixelBox = PixelBox { u: 60.0, v: 40.0, w: 20.0, h: 10.0 };

    /// Ten frames a second, a letter each. The target: P present, p a third of it, a absent. The track: T on
    /// the target, C coasting there, D on the distractor, - lost.
    fn metrics_of(target: &str, track: &str) -> AbsenceMetrics {
        let frame = |(index, (target, track)): (usize, (char, char))| {
            let (bounds, visible_share) = match target {
                'P' => (TARGET, 1.0),
                'p' => (TARGET, 0.33),
                _ => (PixelBox::default(), 0.0),
            };
            let at = |bounds: PixelBox| Localisation {
                captured: Timestamp::ZERO,
                picture: PictureSize::new(100, 60),
                centre: bounds.centre(),
                bounds,
                shape: None,
                heading: None,
                confidence: 0.5,
            };
            let track = match track {
                'T' => Track::Tracking(at(TARGET)),
                'C' => Track::Coasting(at(TARGET)),
                'D' => Track::Tracking(at(OTHER)),
                _ => Track::Lost { since: Timestamp::ZERO, confidence: 0.0 },
            };
            (
                FrameTruth { time_s: index as f64 / 10.0, bounds, visible_share, distractors: vec![OTHER] },
                track,
            )
        };
        let frames: Vec<_> = target.chars().zip(track.chars()).enumerate().map(frame).collect();
        measure(&frames)
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn an_absence_may_be_reported_for_half_a_second() {
        let metrics = metrics_of("PPaaaaaaaaaaPPP", "TTTTTC------TTT");
        assert_eq!((metrics.absent, metrics.absent_late, metrics.absent_late_reported), (10, 4, 0));
        assert!(close(metrics.slowest_loss_s(), 0.4), "{metrics:?}");
        assert_eq!((metrics.found_returns(), metrics.shown, metrics.shown_correct), (1, 5, 5));
    }

    #[test]
    fn late_reports_are_a_share_of_the_late_frames() {
        let metrics = metrics_of("PaaaaaaaaaaP", "TTTTTTTTT--T");
        assert_eq!((metrics.absent_late, metrics.absent_late_reported), (4, 2));
        assert!(
            close(metrics.late_reported_share(), 0.5) && close(metrics.slowest_loss_s(), 0.8),
            "{metrics:?}"
        );
        // A target that is always reported counts with the whole absence.
        assert!(close(metrics_of("PaaaP", "TTTTT").slowest_loss_s(), 0.2));
    }

    #[test]
    fn a_return_counts_from_half_of_the_target_on() {
        let metrics = metrics_of("PaappPPPPP", "T-------TT");
        assert_eq!(metrics.found_after_s.len(), 1);
        assert!(metrics.found_after_s[0].is_some_and(|after_s| close(after_s, 0.3)), "{metrics:?}");
    }

    #[test]
    fn a_return_is_found_by_tracking_the_target_in_time() {
        assert_eq!(metrics_of("PaaPPPPPP", "T--CCCCCC").found_returns(), 0, "coasting");
        assert_eq!(metrics_of("PaaPPPPPP", "T--DDDDDD").found_returns(), 0, "the distractor");
        assert_eq!(metrics_of("PaaPPPPPPPPPPPPP", "T------------TTT").found_returns(), 1, "after 1.0 s");
        assert_eq!(metrics_of("PaaPPPPPPPPPPPPP", "T-------------TT").found_returns(), 0, "after 1.1 s");
        assert_eq!(
            metrics_of("PaapaaPP", "T-----TT").found_after_s.len(),
            1,
            "a target that shows too little has not returned"
        );
    }

    #[test]
    fn time_on_a_distractor_counts_without_interruption() {
        assert!(close(metrics_of("PaaaaaaaaP", "TDD-DDDD-T").on_distractor_s, 0.4));
        assert!(close(metrics_of("PPPPPPPPPP", "TDDDDDDTTT").on_distractor_s, 0.6));
        assert!(close(metrics_of("PPPP", "TTTT").on_distractor_s, 0.0));
    }
}
