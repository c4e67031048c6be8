//! Filters of earlier views of the target.
//!
//! The filter adapts. Once the track has gone over to what hid the target, or to what was beside it, the filter learns that, and
//! responds to it more and more clearly. The filters of earlier views do not adapt: that of the selection, and of later views
//! that none of the kept ones responds to. `reconsidering` looks for the target with them.

use super::appearance::relative_height;
use crate::correlation::{CorrelationFilter, FixedFilter};
use crate::fourier::Spectrum;

/// Number of views. That of the selection stays; the later ones stay, too.
pub(super) const MAX_VIEWS: usize = 3;
/// A view is kept from a frame whose box has more than this probability, ...
pub(super) const MIN_KEPT_PROBABILITY: f32 = 0.8;
/// ... where the response of each kept view is less than this share of its usual height.
const MAX_KNOWN_RESPONSE: f32 = 0.7;
/// Interval, in frames that are learned from, at which the views are compared.
pub(super) const COMPARED_INTERVAL: u32 = 5;

/// The views that are kept of a target.
#[derive(Debug, Clone)]
pub(super) struct FilterViews {
    /// The first is that of the selection; the first `count` are in use.
    views: [FilterView; MAX_VIEWS],
    count: usize,
    /// Whether the target's box was ever probable since the selection.
    pub(super) was_probable: bool,
}

/// One of them.
#[derive(Debug, Clone)]
pub(super) struct FilterView {
    pub(super) filter: FixedFilter,
    /// Usual height of the response when it was kept.
    usual_height: f32,
}

impl FilterView {
    /// Height of a response of this view's filter relative to its usual one.
    pub(super) fn relative(&self, height: f32) -> f32 {
        relative_height(height, self.usual_height)
    }
}

impl FilterViews {
    /// No views, with the memory of all of them for filters with this number of channels.
    pub(super) fn new(channels: usize) -> Self {
        let empty = || FilterView { filter: FixedFilter::new(channels), usual_height: 0.0 };
        Self { views: core::array::from_fn(|_| empty()), count: 0, was_probable: false }
    }

    /// Keeps the view of the selection, and no other.
    pub(super) fn restart(&mut self, filter: &CorrelationFilter, usual_height: f32) {
        (self.count, self.was_probable) = (0, false);
        self.keep(filter, usual_height);
    }

    fn keep(&mut self, filter: &CorrelationFilter, usual_height: f32) {
        if let Some(view) = self.views.get_mut(self.count) {
            view.filter.copy_from(filter);
            view.usual_height = usual_height;
            self.count += 1;
        }
    }

    /// Keeps another view if the target, at the middle of a patch with these spectra, looks like none of the kept ones.
    pub(super) fn keep_if_new(
        &mut self,
        filter: &CorrelationFilter,
        usual_height: f32,
        spectra: &[Spectrum],
    ) {
        let is_known = |view: &FilterView| {
            view.relative(view.filter.response_in_the_middle(spectra)) >= MAX_KNOWN_RESPONSE
        };
        if self.count < MAX_VIEWS && !self.kept().iter().any(is_known) {
            self.keep(filter, usual_height);
        }
    }

    /// The views that are kept.
    pub(super) fn kept(&self) -> &[FilterView] {
        &self.views[..self.count]
    }
}
