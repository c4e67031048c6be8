//! What a tracker makes of a target that leaves the picture and comes back.
//!
//! An *absence* begins with the first frame of which the target is not in the picture at all and ends with the first
//! that shows any of it; the *return* is the first frame after it that shows at least half. A frame is *reported*
//! where the track is tracking or coasting, and *right* where its box overlaps the truth by an IoU of at least 0.3 or
//! has its centre in the truth's box.

use barrelman_vocab::{PixelBox, PixelPoint, Track};

/// The share of the target that must show before a tracker has to find it.
const RETURNED_FROM: f64 = 0.5;

/// Overlap from which on a box is on the target rather than beside it.
const RIGHT_FROM: f64 = 0.3;

/// A box with an overlap below this is on something else.
const ELSEWHERE_BELOW: f64 = 0.1;

/// Time after the target has left in which it may still be reported, seconds.
pub(crate) const GRACE_S: f64 = 0.5;

/// Time in which a target must be found again, seconds.
pub(crate) const FIND_WITHIN_S: f64 = 1.0;

/// What is true of one frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Truth {
    /// Time of capture, seconds from the sequence's start.
    pub(crate) time_s: f64,
    /// The part of the target's box in the picture; empty where it is not there.
    pub(crate) bounds: PixelBox,
    /// Share of the target in the picture, 0 to 1.
    pub(crate) visible: f64,
    /// Boxes of things that look like it.
    pub(crate) distractors: Vec<PixelBox>,
}

/// What became of one sequence.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Judged {
    /// Frames without the target.
    pub(crate) absent: usize,
    /// Of those, the ones later than the grace time after it left.
    pub(crate) absent_late: usize,
    /// Of those, the reported ones.
    pub(crate) absent_late_reported: usize,
    /// For each absence, seconds until it was first said to be lost; the length of the absence where it never was.
    pub(crate) lost_after_s: Vec<f64>,
    /// For each return, seconds until it was tracked rightly; none where it was not within the time for it.
    pub(crate) found_after_s: Vec<Option<f64>>,
    /// Longest time on end on a distractor, seconds.
    pub(crate) on_distractor_s: f64,
    /// Frames that show at least half of the target.
    pub(crate) shown: usize,
    /// Of those, the ones in which it was tracked rightly.
    pub(crate) shown_right: usize,
}

impl Judged {
    /// Adds another's counts to these.
    pub(crate) fn add(&mut self, other: &Self) {
        self.absent += other.absent;
        self.absent_late += other.absent_late;
        self.absent_late_reported += other.absent_late_reported;
        self.lost_after_s.extend(&other.lost_after_s);
        self.found_after_s.extend(&other.found_after_s);
        self.on_distractor_s = self.on_distractor_s.max(other.on_distractor_s);
        self.shown += other.shown;
        self.shown_right += other.shown_right;
    }

    /// Share of the late absent frames that were reported; 0 where there are none.
    pub(crate) fn late_share(&self) -> f64 {
        self.absent_late_reported as f64 / self.absent_late.max(1) as f64
    }

    /// Returns that were found in time.
    pub(crate) fn found(&self) -> usize {
        self.found_after_s.iter().flatten().count()
    }

    /// The longest time until a target was first said to be lost, seconds.
    pub(crate) fn slowest_loss_s(&self) -> f64 {
        self.lost_after_s.iter().copied().fold(0.0, f64::max)
    }
}

/// Judges the frames of one sequence, in order, without the selection's.
pub(crate) fn judge(frames: &[(Truth, Track)]) -> Judged {
    let mut judged = Judged::default();
    for absence in absences(frames) {
        of_absence(&frames[absence.clone()], &mut judged);
        of_return(&frames[absence.end..], &mut judged);
    }
    for (truth, track) in frames.iter().filter(|(truth, _)| truth.visible >= RETURNED_FROM) {
        judged.shown += 1;
        judged.shown_right += usize::from(right(truth, track));
    }
    judged.on_distractor_s = longest_on_distractor_s(frames);
    judged
}

/// Ranges of frames without the target.
fn absences(frames: &[(Truth, Track)]) -> Vec<std::ops::Range<usize>> {
    let mut absences = Vec::new();
    let mut from = 0;
    for part in frames.chunk_by(|(a, _), (b, _)| (a.visible <= 0.0) == (b.visible <= 0.0)) {
        if part[0].0.visible <= 0.0 {
            absences.push(from..from + part.len());
        }
        from += part.len();
    }
    absences
}

fn of_absence(frames: &[(Truth, Track)], judged: &mut Judged) {
    let left_s = frames[0].0.time_s;
    judged.absent += frames.len();
    for (_, track) in frames.iter().filter(|(truth, _)| truth.time_s - left_s > GRACE_S) {
        judged.absent_late += 1;
        judged.absent_late_reported += usize::from(track.localisation().is_some());
    }
    let lost = frames.iter().find(|(_, track)| track.localisation().is_none());
    let last_s = frames[frames.len() - 1].0.time_s;
    judged.lost_after_s.push(lost.map_or(last_s, |(truth, _)| truth.time_s) - left_s);
}

/// `frames` begin with the end of an absence.
fn of_return(frames: &[(Truth, Track)], judged: &mut Judged) {
    // A target that shows less than half, and leaves again, has not returned.
    let until = frames.iter().position(|(truth, _)| truth.visible <= 0.0).unwrap_or(frames.len());
    let frames = &frames[..until];
    let Some(returned) = frames.iter().position(|(truth, _)| truth.visible >= RETURNED_FROM) else { return };
    let frames = &frames[returned..];
    let since_s = frames[0].0.time_s;
    let found =
        frames.iter().find(|(truth, track)| right(truth, track)).map(|(truth, _)| truth.time_s - since_s);
    judged.found_after_s.push(found.filter(|after_s| *after_s <= FIND_WITHIN_S));
}

/// Whether the target is seen where it is; coasting is not seeing.
fn right(truth: &Truth, track: &Track) -> bool {
    let Track::Tracking(seen) = track else { return false };
    seen.bounds.iou(truth.bounds) >= RIGHT_FROM || holds(truth.bounds, seen.bounds.centre())
}

fn on_distractor(truth: &Truth, track: &Track) -> bool {
    let Some(seen) = track.localisation() else { return false };
    let centre = seen.bounds.centre();
    seen.bounds.iou(truth.bounds) < ELSEWHERE_BELOW
        && truth.distractors.iter().any(|distractor| holds(*distractor, centre))
}

/// A single frame counts for the time to the next.
fn longest_on_distractor_s(frames: &[(Truth, Track)]) -> f64 {
    let mut longest_s = 0.0_f64;
    let mut since_s = None;
    for (index, (truth, track)) in frames.iter().enumerate() {
        if !on_distractor(truth, track) {
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

fn holds(bounds: PixelBox, point: PixelPoint) -> bool {
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

    /// Ten frames a second, a letter each. The target: P present, p a third of it, a absent. The track: T on the
    /// target, C coasting there, D on the distractor, - lost.
    fn judged(target: &str, track: &str) -> Judged {
        let frame = |(index, (target, track)): (usize, (char, char))| {
            let (bounds, visible) = match target {
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
            (Truth { time_s: index as f64 / 10.0, bounds, visible, distractors: vec![OTHER] }, track)
        };
        let frames: Vec<_> = target.chars().zip(track.chars()).enumerate().map(frame).collect();
        judge(&frames)
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn an_absence_may_be_reported_for_half_a_second() {
        let judged = judged("PPaaaaaaaaaaPPP", "TTTTTC------TTT");
        assert_eq!((judged.absent, judged.absent_late, judged.absent_late_reported), (10, 4, 0));
        assert!(close(judged.slowest_loss_s(), 0.4), "{judged:?}");
        assert_eq!((judged.found(), judged.shown, judged.shown_right), (1, 5, 5));
    }

    #[test]
    fn what_is_reported_later_is_a_share_of_the_late_frames() {
        let judged = judged("PaaaaaaaaaaP", "TTTTTTTTT--T");
        assert_eq!((judged.absent_late, judged.absent_late_reported), (4, 2));
        assert!(close(judged.late_share(), 0.5) && close(judged.slowest_loss_s(), 0.8), "{judged:?}");
        // One that is never said to be lost counts with the whole absence.
        assert!(close(self::judged("PaaaP", "TTTTT").slowest_loss_s(), 0.2));
    }

    #[test]
    fn a_return_counts_from_half_of_the_target_on() {
        let judged = judged("PaappPPPPP", "T-------TT");
        assert_eq!(judged.found_after_s.len(), 1);
        assert!(judged.found_after_s[0].is_some_and(|after_s| close(after_s, 0.3)), "{judged:?}");
    }

    #[test]
    fn a_return_is_found_by_tracking_the_right_thing_in_time() {
        assert_eq!(judged("PaaPPPPPP", "T--CCCCCC").found(), 0, "coasting");
        assert_eq!(judged("PaaPPPPPP", "T--DDDDDD").found(), 0, "the distractor");
        assert_eq!(judged("PaaPPPPPPPPPPPPP", "T------------TTT").found(), 1, "after 1.0 s");
        assert_eq!(judged("PaaPPPPPPPPPPPPP", "T-------------TT").found(), 0, "after 1.1 s");
        assert_eq!(
            judged("PaapaaPP", "T-----TT").found_after_s.len(),
            1,
            "what shows too little has not returned"
        );
    }

    #[test]
    fn time_on_a_distractor_is_counted_on_end() {
        assert!(close(judged("PaaaaaaaaP", "TDD-DDDD-T").on_distractor_s, 0.4));
        assert!(close(judged("PPPPPPPPPP", "TDDDDDDTTT").on_distractor_s, 0.6));
        assert!(close(judged("PPPP", "TTTT").on_distractor_s, 0.0));
    }
}
