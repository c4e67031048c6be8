//! What is asked of a scene.

use barrelman_vocab::PictureSize;

/// Frames per second of every scene.
pub(super) const FRAMES_PER_SECOND: u32 = 30;

/// What happens in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SceneKind {
    /// The boat is under way, turns, stops, shrinks and grows (by a factor of up to 2); always in view.
    Manoeuvre,
    /// The boat leaves the picture and comes back, at the same or another border, because the camera pans or the
    /// boat drives; nothing of it shows for 3 to 8 s, and after that it is back for 3 s at least. As often as the
    /// length allows: a clip of less than 15 s may have no exit. Nothing else has the boat's colour.
    ExitAndReturn,
    /// The same with things of the boat's very paint, of half to twice its area: buoys, rafts, roofs that pass
    /// through the picture or stay in it, some where the boat leaves or comes back. At most two in view at once.
    ExitAndReturnWithDistractor,
}

/// The hull's paint. Every boat has a darker cockpit, a stripe across the bow (light, or blue on a white hull) and
/// a dark engine at the stern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TargetPaint {
    /// Signal red.
    Red,
    /// Lifeboat orange.
    Orange,
    /// White, like foam.
    White,
    /// Grey, like much water.
    Grey,
}

/// What is asked of a scene; the rest is drawn from the seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneScript {
    /// What happens.
    pub kind: SceneKind,
    /// Size of the pictures; 1280 x 720 is what lengths and speeds are made for, others scale with the width.
    pub size: PictureSize,
    /// Length of the hull when the clip begins and the boat lies across the picture, px, 20 to 200; held to 0.3 of
    /// the picture's shorter side.
    pub boat_px: f64,
    /// Length of the clip, s.
    pub seconds: f64,
    /// The hull's paint.
    pub target: TargetPaint,
}
