//! Framing: the part of the region in which the law holds the target so that the destination is in the
//! picture, too.
//!
//! In semi-axes of the region, the region is the unit disc, and the picture a rectangle around it. While the
//! destination lies beyond the border of the picture for a target at the region's far end, the law holds the
//! target in a smaller disc inside of the unit disc, on the side that is away from the destination:
//!
//! ```text
//!   +---------------------------+
//!   |        .-------.          |   n   by how much the destination, seen from a target at the far end of the
//!   |      /  .--.     \        |       unit disc, lies beyond the margin, along each axis
//!   |     |  | o  |     |   d   |   o = -n / 2, of a length of at most MAX_SHIFT: centre of the smaller disc
//!   |      \  '--'     /        |   1 - |o|: its radius
//!   |        '-------'          |
//!   +---------------------------+
//! ```
//!
//! A destination that cannot be shown so shifts nothing: the law holds the target in the whole region. The
//! target is never held outside of the region.

use barrelman_vocab::{Framed, ImagePoint, Timestamp};

use crate::law_input::LawInput;
use crate::region::Region;
use crate::transfer::Pair;

/// The destination is shown within this share of half the picture's width and height.
const MARGIN: f64 = 0.95;
/// Largest shift of the disc, semi-axes of the region: half of the region is left.
const MAX_SHIFT: f64 = 0.5;
/// A destination that is being shown may be this far beyond what can be shown, semi-axes.
const HYSTERESIS: f64 = 0.2;
/// Time constant of the shift, seconds: it does not follow the sway.
const SMOOTHING_S: f64 = 1.0;

/// Where in the picture the law holds the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeldRegion {
    centre: ImagePoint,
    a_px: f64,
    b_px: f64,
}

impl HeldRegion {
    /// The whole region.
    pub(super) fn whole(region: Region) -> Self {
        Self::shifted(region, [0.0; 2])
    }

    /// The smaller disc around `shift`, semi-axes of the region.
    fn shifted(region: Region, shift: Pair) -> Self {
        let radius = 1.0 - libm::hypot(shift[0], shift[1]);
        Self {
            centre: ImagePoint { x: shift[0] * region.a_px, y: shift[1] * region.b_px },
            a_px: radius * region.a_px,
            b_px: radius * region.b_px,
        }
    }

    /// A point relative to the centre, pixels.
    pub(super) fn relative_to_centre(&self, point: ImagePoint) -> ImagePoint {
        ImagePoint { x: point.x - self.centre.x, y: point.y - self.centre.y }
    }

    /// The semi-axes to the right and up, pixels.
    pub(super) const fn semi_axes_px(&self) -> Pair {
        [self.a_px, self.b_px]
    }

    /// P of a point: at most 1 inside, more than 1 outside.
    pub(super) fn p(&self, point: ImagePoint) -> f64 {
        let Self { a_px, b_px, .. } = *self;
        Region { a_px, b_px }.p(self.relative_to_centre(point))
    }
}

/// The shift of the disc, with its state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Framing {
    framed: Framed,
    shift: Pair,
    /// Whether the destination can be shown.
    is_shown: bool,
    last: Option<Timestamp>,
}

impl Framing {
    pub(super) const fn new(framed: Framed) -> Self {
        Self { framed, shift: [0.0; 2], is_shown: false, last: None }
    }

    /// The region in which the target is held, for the destination of the input.
    pub(super) fn region(&mut self, input: &LawInput<'_>) -> HeldRegion {
        let Some(destination) = input.destination.filter(|_| self.framed == Framed::Both) else {
            return HeldRegion::whole(input.region);
        };
        let wanted = self.wanted(destination, input);
        let interval_s = self.last.map_or(0.0, |last| input.captured.since(last).as_secs_f64());
        self.last = Some(input.captured);
        let share = 1.0 - libm::exp(-interval_s / SMOOTHING_S);
        self.shift = [0, 1].map(|axis| self.shift[axis] + share * (wanted[axis] - self.shift[axis]));
        HeldRegion::shifted(input.region, self.shift)
    }

    fn wanted(&mut self, destination: ImagePoint, input: &LawInput<'_>) -> Pair {
        let ImagePoint { x, y } = input.percept.position;
        let Region { a_px, b_px } = input.region;
        let way = [(destination.x - x) / a_px, (destination.y - y) / b_px];
        let picture = input.picture;
        let margins =
            [MARGIN * 0.5 * f64::from(picture.width) / a_px, MARGIN * 0.5 * f64::from(picture.height) / b_px];
        let beyond = |radius: f64| {
            [0, 1].map(|axis| {
                let excess: f64 = (way[axis].abs() + radius - margins[axis]).max(0.0);
                libm::copysign(excess, way[axis])
            })
        };
        let length = |pair: Pair| libm::hypot(pair[0], pair[1]);
        let reach = MAX_SHIFT + if self.is_shown { HYSTERESIS } else { 0.0 };
        self.is_shown = length(beyond(0.0)) <= reach;
        if !self.is_shown {
            return [0.0; 2];
        }
        let excess = beyond(1.0);
        let scale = (0.5 * length(excess)).min(MAX_SHIFT) / length(excess).max(f64::MIN_POSITIVE);
        excess.map(|excess| -scale * excess)
    }
}
