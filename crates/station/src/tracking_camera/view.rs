//! What ground stations are told of a snapshot.

use std::time::Duration;

use barrelman_console_server::snapshot::Snapshot;
use barrelman_vocab::{Timestamp, Track, VideoNumber};
use barrelman_wire::mavlink::tracking_camera::{Shown, ShownTarget};

/// A target in a picture that is older than this is not shown any more.
const MAX_AGE: Duration = Duration::from_secs(1);

/// What is shown of a snapshot at `now`. A selection that is not confirmed yet is no target, nor is what a
/// detector doubts, nor what is followed in the second video: ground stations show the first.
pub(super) fn view(snapshot: &Snapshot, now: Timestamp) -> Shown {
    let Some((captured, picture)) = snapshot.video.frame else { return Shown::default() };
    let target = match &snapshot.outcome {
        _ if snapshot.video.number != VideoNumber::First => ShownTarget::None,
        Some(outcome) if outcome.is_target_uncertain() => ShownTarget::None,
        Some(outcome) => shown_target(&outcome.track, now.since(captured)),
        None => ShownTarget::None,
    };
    Shown { picture: Some(picture), frames_per_second: snapshot.video.fps as f32, target }
}

/// What is shown of a track in a picture of this age.
fn shown_target(track: &Track, age: Duration) -> ShownTarget {
    match track {
        Track::Unseeded => ShownTarget::None,
        _ if age > MAX_AGE => ShownTarget::Lost,
        Track::Tracking(seen) => ShownTarget::Seen(seen.bounds),
        Track::Coasting(predicted) => ShownTarget::Predicted(predicted.bounds),
        Track::Lost { .. } => ShownTarget::Lost,
    }
}

#[cfg(test)]
mod tests {
    use barrelman_console_server::snapshot::VideoSnapshot;
    use barrelman_pilot::Outcome;
    use barrelman_vocab::{Localisation, PictureSize, PixelBox};

    use super::*;

    const PICTURE: PictureSize = PictureSize::new(640, 480);

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    fn shown(track: Track, age_ms: u64) -> ShownTarget {
        shown_target(&track, Duration::from_millis(age_ms))
    }

    #[test]
    fn a_target_is_shown_once_it_is_confirmed_and_while_the_picture_is_fresh() {
        let bounds = PixelBox { u: 300.0, v: 230.0, w: 40.0, h: 20.0 };
        let centre = bounds.centre();
        let seen = Localisation {
            captured: at(0),
            picture: PICTURE,
            centre,
            bounds,
            shape: None,
            heading: None,
            confidence: 0.75,
        };
        assert_eq!(shown(Track::Tracking(seen), 100), ShownTarget::Seen(bounds));
        assert_eq!(shown(Track::Coasting(seen), 100), ShownTarget::Predicted(bounds));
        assert_eq!(shown(Track::Tracking(seen), 1500), ShownTarget::Lost);
        assert_eq!(shown(Track::Lost { since: at(0), confidence: 0.1 }, 100), ShownTarget::Lost);
        assert_eq!(shown(Track::Unseeded, 5000), ShownTarget::None);
        let outcome = Outcome { track: Track::Tracking(seen), ..Outcome::idle(at(100)) };
        let target = |outcome: Outcome| {
            let video = VideoSnapshot { frame: Some((at(0), PICTURE)), ..VideoSnapshot::default() };
            view(&Snapshot { outcome: Some(outcome), video, ..Snapshot::default() }, at(100)).target
        };
        assert_eq!(target(outcome.clone()), ShownTarget::Seen(bounds));
        assert_eq!(target(Outcome { is_confirming: true, ..outcome.clone() }), ShownTarget::None);
        let video = VideoSnapshot {
            frame: Some((at(0), PICTURE)),
            number: VideoNumber::Second,
            ..VideoSnapshot::default()
        };
        let second = Snapshot { outcome: Some(outcome.clone()), video, ..Snapshot::default() };
        assert_eq!(view(&second, at(100)).target, ShownTarget::None);
        assert_eq!(target(Outcome { is_doubted: true, ..outcome }), ShownTarget::None);
    }

    #[test]
    fn before_the_first_step_there_is_no_target_and_before_the_first_picture_nothing() {
        let video = VideoSnapshot { frame: Some((at(0), PICTURE)), ..VideoSnapshot::default() };
        let snapshot = Snapshot { video, ..Snapshot::default() };
        assert_eq!(view(&snapshot, at(100)), Shown { picture: Some(PICTURE), ..Shown::default() });
        assert_eq!(view(&Snapshot::default(), at(0)), Shown::default());
    }
}
