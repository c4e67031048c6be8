//! A chunk: 64 neighbouring pixels of a row that are shaded together. Each quantity is an array of its own,
//! so that every step is a plain loop that the compiler vectorises.

/// Pixels in a chunk.
pub(super) const CHUNK: usize = 64;
/// One quantity of all pixels of a chunk.
pub(super) type Lane = [f32; CHUNK];

/// Directions, surface and light of a chunk.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    /// Line of sight in the world, with length 1 along the optical axis.
    pub(super) dx: Lane,
    pub(super) dy: Lane,
    pub(super) dz: Lane,
    /// Where the line meets the water or the floor, along the world's x and y from below the camera, metres.
    pub(super) px: Lane,
    pub(super) py: Lane,
    /// Length of the line in units of the direction.
    pub(super) t: Lane,
    /// Width of the pixel's footprint, metres: geometric mean of along and across.
    pub(super) footprint: Lane,
    /// Slope of the surface along x and y.
    pub(super) sx: Lane,
    pub(super) sy: Lane,
    /// Elevation of the swell, metres.
    pub(super) elevation: Lane,
    /// Foam cover of the surface, 0 to 1, and air in the water below.
    pub(super) foam: Lane,
    pub(super) air: Lane,
    /// Remaining share of the sun's light.
    pub(super) lit: Lane,
    /// Reflection of objects, colour times opacity; and the remaining share of the sky's reflection.
    pub(super) reflection: [Lane; 3],
    pub(super) sky_left: Lane,
    /// Resulting linear colour.
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
