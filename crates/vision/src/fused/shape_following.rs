//! How axis, centre and size of a target follow a measured silhouette.

use super::geometry::TargetGeometry;
use super::reference_silhouette::ReferenceSilhouette;
use super::time_constant::rate_in;
use crate::silhouette::Silhouette;

/// Time constants, seconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct FollowingTimes {
    pub(super) axis_s: f64,
    pub(super) centre_s: f64,
    pub(super) size_s: f64,
}

/// Corrects axis, centre, length and breadth by a silhouette, `seconds` after the last frame.
pub(super) fn follow_shape(
    geometry: &mut TargetGeometry,
    reference: &ReferenceSilhouette,
    seen: &Silhouette,
    times: FollowingTimes,
    seconds: f32,
) {
    let rate = |time_s: f64| rate_in(f64::from(seconds), time_s);
    // The axis of a more elongated silhouette has more weight.
    let elongation = (1.0 - seen.roundness()).clamp(0.0, 1.0);
    geometry.axis += rate(times.axis_s) * elongation * axis_difference(seen.axis, geometry.axis);
    let centre = reference.box_centre_of(seen, geometry.axis);
    let centre_rate = rate(times.centre_s);
    geometry.centre.0 += centre_rate * (centre.0 - geometry.centre.0);
    geometry.centre.1 += centre_rate * (centre.1 - geometry.centre.1);
    let (length, breadth) = reference.size_of(seen);
    geometry.stretch_to(length, breadth, rate(times.size_s));
}

/// Difference of two axes, -pi/2 to pi/2.
pub(super) fn axis_difference(to: f32, from: f32) -> f32 {
    let pi = core::f32::consts::PI;
    let turns = (to - from) / pi;
    (turns - (turns + 0.5).floor()) * pi
}
