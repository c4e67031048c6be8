//! Objects on the water: their paint and their motion.

use barrelman_vocab::PixelBox;

use super::canvas::Canvas;
use super::colour::{Yuv, lit};
use super::outline::Outline;
use super::view::{PlanePoint, View};

/// The paint of an object by position: `along` from -1 (stern) to 1 (bow), `across` from -1 to 1.
#[derive(Debug, Clone)]
pub(super) enum PaintScheme {
    /// A boat: hull, a darker cockpit, a stripe across the bow, a dark engine at the stern.
    Boat {
        hull: Yuv,
        cockpit: Yuv,
        stripe: Yuv,
        engine: Yuv,
    },
    /// One paint with a spot in the middle.
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

impl PaintScheme {
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

/// Outline and paint of a floating object.
#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) outline: Outline,
    pub(super) paint_scheme: PaintScheme,
}

/// Position of a body's middle in the plane, and direction of its bow there (radians, anticlockwise from x).
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanePose {
    pub(super) at: PlanePoint,
    pub(super) heading: f64,
}

/// Conditions under which a body is rendered.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObjectExposure<'a> {
    pub(super) view: &'a View,
    /// Motion of the body in the picture during the exposure, px (u, v).
    pub(super) motion: (f64, f64),
    /// Direction of the sun in the plane, radians.
    pub(super) sun: f64,
}

impl Body {
    pub(super) fn render(&self, canvas: &mut Canvas, plane_pose: PlanePose, exposure: ObjectExposure<'_>) {
        let ObjectExposure { view, motion, sun } = exposure;
        let around = self.outline.silhouette(plane_pose.at, plane_pose.heading, view).bounds();
        let middle = view.picture(plane_pose.at);
        let (s, c) = (libm::sin(plane_pose.heading), libm::cos(plane_pose.heading));
        // The side towards the sun is the brighter one.
        let (sun_along, sun_across) =
            (libm::cos(sun - plane_pose.heading), libm::sin(sun - plane_pose.heading));
        canvas.paint(around, motion, |u, v| {
            let (x, y) = view.plane_offset(u - middle.u, v - middle.v);
            let (along, across) = self.outline.normalised_offset(x * c + y * s, y * c - x * s)?;
            let gain = 1.0 + SHADING * (0.5 * along * sun_along + across * sun_across);
            Some(lit(self.paint_scheme.colour(along, across), gain as f32))
        });
    }
}

/// Share of the light by which the sunlit side is brighter than the middle.
const SHADING: f64 = 0.14;

/// A body that rests on the water or moves uniformly.
#[derive(Debug, Clone)]
pub(super) struct SceneObject {
    pub(super) body: Body,
    /// Pose at the start of the clip.
    pub(super) plane_pose: PlanePose,
    /// Velocity, in the plane's unit per second.
    pub(super) velocity: (f64, f64),
}

impl SceneObject {
    pub(super) fn pose_at(&self, time_s: f64) -> PlanePose {
        let at = self.plane_pose.at.offset(self.velocity.0 * time_s, self.velocity.1 * time_s);
        PlanePose { at, ..self.plane_pose }
    }

    /// The box around the object's part in the picture; empty if the object is outside.
    pub(super) fn bounds(&self, time_s: f64, view: &View) -> PixelBox {
        let PlanePose { at, heading } = self.pose_at(time_s);
        self.body.outline.silhouette(at, heading, view).clipped(view.size).bounds().clipped(view.size)
    }
}
