//! What is learned of a target at its selection: what the tracker searches for after a rejection.
//!
//! Filters of earlier views and the reliable size follow from the target as it was at the selection. Everything
//! else that a follower holds is a buffer, or belongs to the path since.

use super::blob::TargetPaint;
use super::confidence::Confidence;
use super::target::Target;
use crate::refinement::WindowMemory;

/// A target as it was at its selection.
#[derive(Debug)]
pub(super) struct LearnedTarget {
    pub(super) target: Target,
    /// What the window of the refinement network showed.
    pub(super) window_memory: WindowMemory,
    /// The target's paint, if the target has one that sets it apart.
    pub(super) paint: Option<TargetPaint>,
    pub(super) judgement: Confidence,
}
