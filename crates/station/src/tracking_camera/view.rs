//! What ground stations are told of a snapshot.

use std::time::Duration;

use barrelman_vocab::{Timestamp, Track};
use barrelman_wire::mavlink::tracking_camera::{Shown, ShownTarget};

use crate::snapshot::Snapshot;

/// A target in a picture that is older than this is not shown any more.
const MAX_AGE: Duration = Duration::from_secs(1);

/// What is shown of a snapshot at `now`. A selection that is not confirmed yet is no target.
pub(super) fn view(snapshot: &Snapshot, now: Timestamp) -> Shown {
    let Some((captured, picture)) = snapshot.video.frame else { return Shown::default() };
    let target = match &snapshot.outcome {
        Some(outcome) if !outcome.is_confirming => match &outcome.track {
            Track::Unseeded => ShownTarget::None,
            _ if now.since(captured) > MAX_AGE => ShownTarget::Lost,
            Track::Tracking(seen) => ShownTarget::Seen(seen.bounds),
            Track::Coasting(predicted) => ShownTarget::Predicted(predicted.bounds),
            Track::Lost { .. } => ShownTarget::Lost,
        },
        _ => ShownTarget::None,
    };
    Shown { picture: Some(picture), frames_per_second: snapshot.video.fps as f32, target }
}

#[cfg(test)]
mod tests {
    use barrelman_pilot::Outcome;

    use super::*;
    use crate::snapshot::VideoSnapshot;
    use crate::test_scenes::{PICTURE, at, idle, localisation};

    fn shown(track: Track, is_confirming: bool, now_ms: u64) -> ShownTarget {
        let outcome = Outcome { track, is_confirming, ..idle(at(0)) };
        let video = VideoSnapshot { frame: Some((at(0), PICTURE)), ..VideoSnapshot::default() };
        let snapshot = Snapshot { outcome: Some(outcome), video, ..Snapshot::default() };
        let shown = view(&snapshot, at(now_ms));
        assert_eq!(shown.picture, Some(PICTURE));
        shown.target
    }

    #[test]
    fn a_target_is_shown_once_it_is_confirmed_and_while_the_picture_is_fresh() {
        let seen = localisation(at(0));
        assert_eq!(shown(Track::Tracking(seen), false, 100), ShownTarget::Seen(seen.bounds));
        assert_eq!(shown(Track::Coasting(seen), false, 100), ShownTarget::Predicted(seen.bounds));
        assert_eq!(shown(Track::Tracking(seen), true, 100), ShownTarget::None);
        assert_eq!(shown(Track::Tracking(seen), false, 1500), ShownTarget::Lost);
        assert_eq!(shown(Track::Lost { since: at(0), confidence: 0.1 }, false, 100), ShownTarget::Lost);
        assert_eq!(shown(Track::Unseeded, false, 5000), ShownTarget::None);
    }

    #[test]
    fn before_the_first_picture_there_is_nothing_to_show() {
        assert_eq!(view(&Snapshot::default(), at(0)), Shown::default());
    }
}
