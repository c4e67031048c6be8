//! What ground stations are told of a snapshot.

use std::time::Duration;

use barrelman_console_server::snapshot::Snapshot;
use barrelman_vocab::{Timestamp, Track};
use barrelman_wire::mavlink::tracking_camera::{Shown, ShownTarget};

/// A target in a picture that is older than this is not shown any more.
const MAX_AGE: Duration = Duration::from_secs(1);

/// What is shown of a snapshot at `now`. A selection that is not confirmed yet is no target.
pub(super) fn view(snapshot: &Snapshot, now: Timestamp) -> Shown {
    let Some((captured, picture)) = snapshot.video.frame else { return Shown::default() };
    let target = match &snapshot.outcome {
        Some(outcome) => shown_target(&outcome.track, outcome.is_confirming, now.since(captured)),
        None => ShownTarget::None,
    };
    Shown { picture: Some(picture), frames_per_second: snapshot.video.fps as f32, target }
}

/// What is shown of a track in a picture of this age.
fn shown_target(track: &Track, is_confirming: bool, age: Duration) -> ShownTarget {
    match track {
        _ if is_confirming => ShownTarget::None,
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
    use barrelman_vocab::{Localisation, PictureSize, PixelBox};

    use super::*;

    const PICTURE: PictureSize = PictureSize::new(640, 480);

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    fn shown(track: Track, is_confirming: bool, age_ms: u64) -> ShownTarget {
        shown_target(&track, is_confirming, Duration::from_millis(age_ms))
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
        assert_eq!(shown(Track::Tracking(seen), false, 100), ShownTarget::Seen(bounds));
        assert_eq!(shown(Track::Coasting(seen), false, 100), ShownTarget::Predicted(bounds));
        assert_eq!(shown(Track::Tracking(seen), true, 100), ShownTarget::None);
        assert_eq!(shown(Track::Tracking(seen), false, 1500), ShownTarget::Lost);
        assert_eq!(shown(Track::Lost { since: at(0), confidence: 0.1 }, false, 100), ShownTarget::Lost);
        assert_eq!(shown(Track::Unseeded, false, 5000), ShownTarget::None);
    }

    #[test]
    fn before_the_first_step_there_is_no_target_and_before_the_first_picture_nothing() {
        let video = VideoSnapshot { frame: Some((at(0), PICTURE)), ..VideoSnapshot::default() };
        let snapshot = Snapshot { video, ..Snapshot::default() };
        assert_eq!(view(&snapshot, at(100)), Shown { picture: Some(PICTURE), ..Shown::default() });
        assert_eq!(view(&Snapshot::default(), at(0)), Shown::default());
    }
}
