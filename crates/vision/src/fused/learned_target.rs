//! What is learned of a target at its selection. The tracker searches for this target after a rejection.
//!
//! The filters of earlier views and the reliable size follow from the target at the selection. All other
//! fields of a follower are buffers, or belong to the path since the selection.

use super::blob::TargetPaint;
use super::confidence::Confidence;
use super::target::Target;
use crate::refinement::WindowMemory;

/// A target as it was at its selection.
#[derive(Debug)]
pub(super) struct LearnedTarget {
    pub(super) target: Target,
    /// The window of the refinement network at the selection.
    pub(super) window_memory: WindowMemory,
    /// The target's paint, if the target has one that differs from its surroundings.
    pub(super) paint: Option<TargetPaint>,
    pub(super) judgement: Confidence,
}
