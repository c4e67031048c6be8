//! Things on the water: what they look like and where they are.

use barrelman_vocab::PixelBox;

use super::canvas::Canvas;
use super::colour::{Yuv, lit};
use super::outline::Outline;
use super::view::{PlanePoint, View};

/// How a thing is painted, by place: `along` from -1 (stern) to 1 (bow), `across` from -1 to 1.
#[derive(Debug, Clone)]
pub(super) enum Livery {
    /// A boat: hull, a darker cockpit, a stripe across the bow, a dark engine at the stern.
    Boat {
        hull: Yuv,
        cockpit: Yuv,
        stripe: Yuv,
        engine: Yuv,
    },
    /// All over, with a spot in the middle.
    Spotted {
        paint: Yuv,
        spot: Yuv,
    },
    /// Planks across, with dark joints.
    Planks {
        paint: Yuv,
        joints: f64,
    },
    Plain(Yuv),
}

impl Livery {
    fn colour(&self, along: f64, across: f64) -> Yuv {
        match self {
            Self::Boat { hull, cockpit, stripe, engine } => {
                if along < -0.84 && across.abs() < 0.34 {
                    *engine
                } else if (0.42..0.58).contains(&along) {
                    *stripe
                } else if (-0.6..0.18).contains(&along) && across.abs() < 0.56 {
                    *cockpit
                } else {
                    *hull
                }
            }
            Self::Spotted { paint, spot } => {
                if along * along + across * across < 0.1 {
                    *spot
                } else {
                    *paint
                }
            }
            Self::Planks { paint, joints } => {
                let at = (along + 1.0) * joints;
                if at - at.floor() < 0.18 { lit(*paint, 0.7) } else { *paint }
            }
            Self::Plain(paint) => *paint,
        }
    }
}

/// What floats: its outline and its paint.
#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) outline: Outline,
    pub(super) livery: Livery,
}

/// Where a body is: its middle in the plane and its bow's direction there (radians, anticlockwise from x).
#[derive(Debug, Clone, Copy)]
pub(super) struct Berth {
    pub(super) at: PlanePoint,
    pub(super) heading: f64,
}

/// How one picture is taken of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shot<'a> {
    pub(super) view: &'a View,
    /// How far the body moves in the picture during the exposure, px (u, v).
    pub(super) motion: (f64, f64),
    /// Direction of the sun in the plane, radians.
    pub(super) sun: f64,
}

impl Body {
    pub(super) fn draw(&self, canvas: &mut Canvas, berth: Berth, shot: Shot<'_>) {
        let Shot { view, motion, sun } = shot;
        let around = self.outline.silhouette(berth.at, berth.heading, view).bounds();
        let middle = view.picture(berth.at);
        let (s, c) = (libm::sin(berth.heading), libm::cos(berth.heading));
        // The side towards the sun is the brighter one.
        let (sun_along, sun_across) = (libm::cos(sun - berth.heading), libm::sin(sun - berth.heading));
        canvas.paint(around, motion, |u, v| {
            let (x, y) = view.plane_offset(u - middle.u, v - middle.v);
            let (along, across) = self.outline.locate(x * c + y * s, y * c - x * s)?;
            let gain = 1.0 + SHADING * (0.5 * along * sun_along + across * sun_across);
            Some(lit(self.livery.colour(along, across), gain as f32))
        });
    }
}

/// Share of the light by which the bright side of a thing differs from its middle.
const SHADING: f64 = 0.14;

/// A body that rests on the water or moves straight on.
#[derive(Debug, Clone)]
pub(super) struct Thing {
    pub(super) body: Body,
    /// Where it is when the clip begins.
    pub(super) berth: Berth,
    /// Units of the plane per second.
    pub(super) velocity: (f64, f64),
}

impl Thing {
    pub(super) fn berth(&self, time_s: f64) -> Berth {
        let at = self.berth.at.offset(self.velocity.0 * time_s, self.velocity.1 * time_s);
        Berth { at, ..self.berth }
    }

    /// The box around what of it is in the picture; empty if nothing is.
    pub(super) fn bounds(&self, time_s: f64, view: &View) -> PixelBox {
        let Berth { at, heading } = self.berth(time_s);
        self.body.outline.silhouette(at, heading, view).clipped(view.size).bounds().clipped(view.size)
    }
}
