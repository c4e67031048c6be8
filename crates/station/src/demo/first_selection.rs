//! The first selection of a drive: a world that is begun hands-on waits for it, and the page points at the
//! boat until then.

use std::collections::VecDeque;

use barrelman_experiments::drive::DriveSetup;
use barrelman_pilot::{Input, Notice, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{OperatorRequest, PixelBox, Timestamp, Track};

/// Whether the time of the world waits for the first selection.
///
/// ```text
/// Awaited --a box is drawn--> Confirming --the boat is tracked--> Over
///    ^  \----the person lets the time go on------------------------^
///    \---the selection fails----/
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FirstSelection {
    /// The time stands still as soon as there is a picture.
    Awaited,
    /// The time goes on: only newer pictures can confirm a selection.
    Confirming,
    /// The time goes on.
    Over,
}

impl FirstSelection {
    /// At the start of a drive.
    pub(super) const fn of(setup: &DriveSetup) -> Self {
        if setup.hands_on { Self::Awaited } else { Self::Over }
    }

    /// Whether the time stands still.
    pub(super) fn waits(self, watch: &SelectionWatch) -> bool {
        self == Self::Awaited && watch.has_picture
    }

    /// The state after a request to the pilot, whose step `watch` has seen. A tap may select, too.
    #[must_use]
    pub(super) const fn after_request(self, request: &OperatorRequest, watch: &SelectionWatch) -> Self {
        let selects = watch.is_confirming
            || matches!(request, OperatorRequest::Camera(request) if request.is_selection());
        match self {
            Self::Awaited if selects => Self::Confirming,
            Self::Awaited | Self::Confirming | Self::Over => self,
        }
    }

    /// The state after the steps that `watch` has seen.
    #[must_use]
    pub(super) const fn after_steps(self, watch: &mut SelectionWatch) -> Self {
        let has_failed = std::mem::replace(&mut watch.has_failed, false);
        match self {
            Self::Confirming if watch.is_selected => Self::Over,
            Self::Confirming if has_failed => Self::Awaited,
            Self::Awaited | Self::Confirming | Self::Over => self,
        }
    }
}

/// What the steps of a drive tell about the first selection.
#[derive(Debug, Default)]
pub(super) struct SelectionWatch {
    has_picture: bool,
    /// Whether a selection waits for its confirmation.
    is_confirming: bool,
    /// Whether a target has been confirmed in this drive.
    is_selected: bool,
    /// Whether a selection was refused or not confirmed since [`FirstSelection::after_steps`].
    has_failed: bool,
    /// Pictures in transit: time of capture and bounds of the boat.
    in_transit: VecDeque<(Timestamp, Option<PixelBox>)>,
    /// Bounds of the boat in the newest picture that the pilot has.
    boat: Option<PixelBox>,
}

impl SelectionWatch {
    /// True bounds of the boat in the newest picture, until something is selected.
    pub(super) fn boat(&self) -> Option<PixelBox> {
        self.boat.filter(|_| !self.is_selected)
    }

    pub(super) fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        if !self.is_selected {
            self.in_transit.push_back((truth.at, target.and_then(|target| target.bounds)));
        }
    }

    pub(super) fn on_step(&mut self, input: &Input<'_>, outcome: &Outcome) {
        if let Input::Frame(frame) = input {
            self.has_picture = true;
            while let Some((_, boat)) = self.in_transit.pop_front_if(|(at, _)| *at <= frame.capture.at) {
                self.boat = boat;
            }
        }
        self.is_confirming = outcome.is_confirming;
        self.is_selected |= matches!(outcome.track, Track::Tracking(_)) && !outcome.is_confirming;
        self.has_failed |=
            matches!(outcome.notice, Some(Notice::SelectionRefused(_) | Notice::SelectionUnconfirmed(_)));
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{CameraRequest, StopCause};

    use super::*;

    const BOX: PixelBox = PixelBox { u: 1.0, v: 2.0, w: 30.0, h: 20.0 };
    const SELECT: OperatorRequest = OperatorRequest::Camera(CameraRequest::SelectNext(BOX));
    const STOP: OperatorRequest = OperatorRequest::Stop(StopCause::Operator);

    fn after(state: FirstSelection, mut watch: SelectionWatch) -> FirstSelection {
        state.after_steps(&mut watch)
    }

    #[test]
    fn the_time_stands_still_from_the_first_picture_until_a_box_is_drawn() {
        let (before, with_picture) =
            (SelectionWatch::default(), SelectionWatch { has_picture: true, ..SelectionWatch::default() });
        assert!(!FirstSelection::Awaited.waits(&before), "there would be no picture to draw on");
        assert!(FirstSelection::Awaited.waits(&with_picture));
        let confirming = FirstSelection::Awaited.after_request(&SELECT, &SelectionWatch::default());
        assert_eq!(confirming, FirstSelection::Confirming);
        assert!(!confirming.waits(&with_picture));
    }

    #[test]
    fn a_request_that_takes_what_is_proposed_lets_the_time_go_on() {
        let confirming = SelectionWatch { is_confirming: true, ..SelectionWatch::default() };
        let engage = OperatorRequest::Camera(CameraRequest::Engage);
        let after = |watch: &SelectionWatch| FirstSelection::Awaited.after_request(&engage, watch);
        assert_eq!(after(&confirming), FirstSelection::Confirming);
        assert_eq!(after(&SelectionWatch::default()), FirstSelection::Awaited);
    }

    #[test]
    fn a_selection_that_fails_makes_the_world_wait_again_and_one_that_holds_does_not() {
        let failed = || SelectionWatch { has_failed: true, ..SelectionWatch::default() };
        let tracked = || SelectionWatch { is_selected: true, ..SelectionWatch::default() };
        assert_eq!(after(FirstSelection::Confirming, SelectionWatch::default()), FirstSelection::Confirming);
        assert_eq!(after(FirstSelection::Confirming, failed()), FirstSelection::Awaited);
        assert_eq!(after(FirstSelection::Confirming, tracked()), FirstSelection::Over);
        assert_eq!(after(FirstSelection::Over, failed()), FirstSelection::Over);
        assert_eq!(
            FirstSelection::Awaited.after_request(&STOP, &SelectionWatch::default()),
            FirstSelection::Awaited
        );
        assert_eq!(
            FirstSelection::Over.after_request(&SELECT, &SelectionWatch::default()),
            FirstSelection::Over
        );
    }

    #[test]
    fn the_boat_is_pointed_at_only_until_it_is_selected() {
        let watch = SelectionWatch { boat: Some(BOX), ..SelectionWatch::default() };
        assert_eq!(watch.boat(), Some(BOX));
        assert_eq!(SelectionWatch { is_selected: true, ..watch }.boat(), None);
    }
}
