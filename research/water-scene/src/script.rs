//! What is asked of a scene.

use barrelman_vocab::PictureSize;

/// Frames per second of every scene.
pub(super) const FRAMES_PER_SECOND: u32 = 30;

/// What happens in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SceneKind {
    /// The boat moves, turns, stops, shrinks and grows (by a factor of up to 2), always in view.
    Manoeuvre,
    /// The boat leaves the picture and returns, across the same or another border, because the camera pans or
    /// the boat drives. It is wholly outside for 3 to 8 s and then in view for at least 3 s, as often as the
    /// length allows: a clip of less than 15 s may have no exit. Nothing else has the boat's colour.
    ExitAndReturn,
    /// As `ExitAndReturn`, with distractors in exactly the boat's paint, of half to twice its area: buoys,
    /// rafts and roofs that pass through the picture or stay in it, some where the boat leaves or returns. At
    /// most two are in view at once.
    ExitAndReturnWithDistractor,
}

/// Paint of the hull. Every boat has a darker cockpit, a stripe across the bow (light, or blue on a white
/// hull) and a dark engine at the stern.
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

/// The chosen parameters of a scene; the seed determines the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneScript {
    /// What happens.
    pub kind: SceneKind,
    /// Picture size. Lengths and speeds are given for 1280 x 720 and scale with the width.
    pub size: PictureSize,
    /// Length of the hull at the start of the clip when the boat lies across the picture, px, 20 to 200; at
    /// most 0.3 of the picture's shorter side.
    pub boat_px: f64,
    /// Length of the clip, s.
    pub seconds: f64,
    /// Paint of the hull.
    pub target: TargetPaint,
}
