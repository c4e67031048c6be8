//! The pixels that are shaded together: 64 neighbours in a row, each quantity an array of its own, so that every stage
//! is a plain loop that a compiler turns into vector instructions.

/// Pixels in a chunk.
pub(super) const CHUNK: usize = 64;
/// A quantity of all pixels.
pub(super) type Lane = [f32; CHUNK];

/// Directions, surface and light of 64 pixels.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    /// Line of sight in the world, not normalised: one unit along the optical axis.
    pub(super) dx: Lane,
    pub(super) dy: Lane,
    pub(super) dz: Lane,
    /// Where it meets the water or the floor, metres from below the camera along the world's x and y.
    pub(super) px: Lane,
    pub(super) py: Lane,
    /// Length of the line in units of the direction.
    pub(super) t: Lane,
    /// Width of the pixel's footprint, metres, a mean of along and across.
    pub(super) footprint: Lane,
    /// Slopes.
    pub(super) sx: Lane,
    pub(super) sy: Lane,
    /// Elevation of the swell, metres.
    pub(super) elevation: Lane,
    /// How much of the surface is foam, 0 to 1, and how much air is in the water below.
    pub(super) foam: Lane,
    pub(super) air: Lane,
    /// Part of the sun that is left.
    pub(super) lit: Lane,
    /// Mirror image of a thing: its colour times its opacity, and what of the sky is left.
    pub(super) reflection: [Lane; 3],
    pub(super) sky_left: Lane,
    /// The result, linear.
    pub(super) colour: [Lane; 3],
}

impl Chunk {
    pub(super) fn new() -> Self {
        const ZERO: Lane = [0.0; CHUNK];
        Self {
            dx: ZERO,
            dy: ZERO,
            dz: ZERO,
            px: ZERO,
            py: ZERO,
            t: ZERO,
            footprint: ZERO,
            sx: ZERO,
            sy: ZERO,
            elevation: ZERO,
            foam: ZERO,
            air: ZERO,
            lit: ZERO,
            reflection: [ZERO; 3],
            sky_left: ZERO,
            colour: [ZERO; 3],
        }
    }
}
