//! What is known of the target from frame to frame.

use barrelman_vocab::track::Shape;
use barrelman_vocab::{
    Angle, Localisation, MotionPrior, PictureSize, PixelBox, PixelPoint, Timestamp, VideoFrame,
};

use super::config::FusedConfig;
use super::evidence::Look;
use super::extent::Extent;
use super::phase::Phase;
use crate::background::Background;
use crate::colour_model::ColourModel;
use crate::correlation::CorrelationFilter;
use crate::features::Place;
use crate::fourier::{Map, SIDE, Spectrum};
use crate::gradients::CELL;
use crate::heading::Heading;
use crate::layout::Layout;
use crate::motion::Axis;
use crate::silhouette::Silhouette;

/// What the colour showed of the target at the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outline {
    /// From the centroid of its colour to the middle of its box, pixels along the axis and across it (clockwise).
    pub(super) offset: (f32, f32),
    /// From halfway between its ends to the middle of its box, likewise.
    pub(super) box_offset: (f32, f32),
    /// By how much the middle of its box lies astern of the hull's, pixels.
    pub(super) astern: f32,
    /// Full axes of the silhouette, pixels.
    pub(super) major: f32,
    pub(super) minor: f32,
    /// Length and breadth of the target then, pixels.
    pub(super) length: f32,
    pub(super) breadth: f32,
}

impl Outline {
    /// By what a later silhouette is longer and wider.
    pub(super) fn stretch_of(&self, seen: &Silhouette) -> (f32, f32) {
        (seen.major / self.major, seen.minor / self.minor)
    }
}

/// The target, as it was last seen.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) phase: Phase,
    /// Its proportions at the selection's size.
    pub(super) extent: Extent,
    /// Root of the area of the selection's box, pixels.
    pub(super) size: f32,
    /// How many times as large it is now.
    pub(super) scale: f32,
    /// By what the patches are turned: radians clockwise since the selection.
    pub(super) angle: f32,
    /// One end of its axis, radians clockwise from image right; follows `angle` where nothing better is known.
    pub(super) axis: f32,
    /// Its centre, pixels.
    pub(super) centre: (f32, f32),
    /// The silhouette's full axes at the selection, pixels, where they can be trusted: what later ones are held
    /// against.
    pub(super) outline: Option<Outline>,
    pub(super) motion: (Axis, Axis),
    /// Whether the last frame came with a motion prior that says as much as the surroundings would.
    pub(super) prior_known: bool,
    /// The shift of this frame that is known less well than it can be measured.
    pub(super) rough_prior: Option<MotionPrior>,
    /// Whether `camera_shift` was measured or told.
    pub(super) camera_known: bool,
    /// How the camera shifted the picture since the last frame, pixels, as far as that is known.
    pub(super) camera_shift: (f32, f32),
    pub(super) heading: Heading,
    pub(super) picture: PictureSize,
    pub(super) last_at: Timestamp,
    pub(super) colours: ColourModel,
    pub(super) filter: CorrelationFilter,
    pub(super) wanted: Spectrum,
    pub(super) mask: Box<Map>,
    /// Cells of the filter from the middle to the edge of the target, right and down.
    pub(super) reach: (usize, usize),
    /// How much more likeness there usually is inside than around.
    pub(super) contrast: f32,
    /// How alike its colours usually are to what was learned of them, 0 to 1.
    pub(super) kinship: f32,
    /// Where on it which colours lie, and how alike that usually is, 0 to 1.
    pub(super) layout: Layout,
    pub(super) layout_kinship: f32,
    /// How high the filter's response usually is.
    pub(super) height: f32,
    /// Frames learned from.
    pub(super) learned: u32,
    pub(super) vanished: Vanished,
    /// While it is perhaps found again.
    pub(super) recognition: Recognition,
    /// Size and proportions when it was last well seen and wholly in the picture.
    pub(super) steady: (f32, Extent),
    /// Frames in which it was seen, and how often in a row its colour was found to lie elsewhere than its box.
    pub(super) refined: u32,
    pub(super) astray: u32,
    /// Frames that it was searched for in, since it was lost.
    pub(super) searched: u32,
    /// Which window of the whole picture is looked at next while it is lost.
    pub(super) scan: u32,
    pub(super) confidence: f64,
}

/// Where and when it was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vanished {
    pub(super) at: Timestamp,
    /// Pixels.
    pub(super) place: (f32, f32),
    /// Whether it was lost in the picture, and did not leave it.
    pub(super) inside: bool,
}

/// What the looks at a target that was perhaps found again have shown so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Recognition {
    /// How many of them.
    pub(super) looks: u32,
    /// The mean of how alike to the target it was: height of the response, kinship of the colours and of their
    /// layout, each in what is usual.
    pub(super) alike: f32,
}

impl Recognition {
    /// With one more look.
    pub(super) fn with(self, alike: f32) -> Self {
        let looks = self.looks.saturating_add(1);
        Self { looks, alike: self.alike + (alike - self.alike) / looks as f32 }
    }
}

/// How alike to the target a thing must be (as [`Recognition::alike`]) that lies where it was lost, or elsewhere.
const STILL_THERE_ALIKE: f32 = 1.8;
const ELSEWHERE_ALIKE: f32 = 2.37;
/// It counts as still there within so many sizes, for so long.
const STILL_THERE_SIZES: f32 = 1.5;
const STILL_THERE_S: f64 = 3.0;

/// Smallest and largest sizes that a target may come to have, in those of the selection and of the picture.
const LEAST_SIDE_PX: f32 = 3.0;

impl Target {
    /// Root of its area, pixels.
    pub(super) fn size_px(&self) -> f32 {
        self.size * self.scale
    }

    /// Width and height of the picture, pixels.
    pub(super) fn bounds(&self) -> (f32, f32) {
        (self.picture.width as f32, self.picture.height as f32)
    }

    pub(super) fn half_axes(&self) -> (f32, f32) {
        self.extent.half_axes(self.scale)
    }

    /// The patch around where it was last.
    pub(super) fn place(&self, config: &FusedConfig) -> Place {
        let half = self.extent.half_axes(1.0);
        let side = (config.padding as f32 * self.size)
            .max(LEAST_WINDOW_SIZES * 2.0 * half.0.max(half.1))
            .max(LEAST_WINDOW_PX);
        Place { centre: self.centre, step: self.scale * side / (SIDE * CELL) as f32, angle: self.angle }
    }

    /// Its axis in a patch that is turned otherwise: it turns with the patch.
    pub(super) fn axis_at(&self, place: &Place) -> f32 {
        self.axis + place.angle - self.angle
    }

    /// Side of the square that is taken for the target in the picture of its surroundings, pixels.
    pub(super) fn blank(&self) -> f32 {
        let half = self.half_axes();
        2.2 * half.0.max(half.1)
    }

    /// Takes a factor of size, if the target stays within reason.
    pub(super) fn rescale(&mut self, factor: f32) {
        let scale = self.scale * factor;
        let (w, h) = self.extent.upright(scale, self.axis);
        let bounds = self.bounds();
        if factor.is_finite() && w.min(h) >= LEAST_SIDE_PX && w <= bounds.0 && h <= bounds.1
            || (factor - 1.0) * (scale - 1.0) < 0.0
        {
            self.scale = scale;
        }
    }

    /// Goes part of the way to a measured length and breadth, pixels.
    pub(super) fn stretch_to(&mut self, long: f32, wide: f32, part: f32) {
        let half = self.half_axes();
        let factor = |measured: f32, known: f32| libm::powf(measured / known, part);
        let (longer, wider) = (factor(long, 2.0 * half.0), factor(wide, 2.0 * half.1));
        // What is common to both is size, the rest is proportion.
        let common = (longer * wider).sqrt();
        self.rescale(common);
        self.extent.stretch(longer / common, wider / common);
    }

    /// Whether part of its box lies outside the picture.
    pub(super) fn touches_border(&self) -> bool {
        let (w, h) = self.extent.upright(self.scale, self.axis);
        let bounds = self.bounds();
        let (u, v) = self.centre;
        u < 0.5 * w || v < 0.5 * h || u > bounds.0 - 0.5 * w || v > bounds.1 - 0.5 * h
    }

    /// Puts everything into pixels of a picture of another size that shows the same.
    pub(super) fn turn_to(&mut self, picture: PictureSize, background: &mut Background) {
        // One without pixels shows nothing, and has no size to put anything into.
        if picture == self.picture || picture.width == 0 || picture.height == 0 {
            return;
        }
        let (u, v) = (
            picture.width as f32 / self.picture.width as f32,
            picture.height as f32 / self.picture.height as f32,
        );
        self.centre = (self.centre.0 * u, self.centre.1 * v);
        self.scale *= (u * v).sqrt();
        self.motion.0.rescale(f64::from(u));
        self.motion.1.rescale(f64::from(v));
        self.picture = picture;
        self.heading.forget();
        background.forget();
    }

    /// Carries the motion on to `now`; the time since the last frame, seconds.
    pub(super) fn predict(
        &mut self,
        config: &FusedConfig,
        now: Timestamp,
        prior: Option<&MotionPrior>,
    ) -> f64 {
        let seconds = now.since(self.last_at).as_secs_f64().clamp(1.0e-3, LONGEST_GAP_S);
        self.last_at = now;
        // What is not a number is not within these either.
        let meant = |p: &&MotionPrior| {
            [p.shift_u_px, p.shift_v_px, p.std_dev_px].iter().all(|pixels| pixels.abs() <= MOST_SHIFT_PX)
        };
        let prior = prior.filter(meant);
        let trusted = |p: &&MotionPrior| p.std_dev_px <= TRUSTED_DEVIATION_PX;
        // What is known less well than it can be measured is for where nothing can be, and what is not known to within
        // the target's size says nothing.
        let size = f64::from(self.size_px());
        self.rough_prior = prior.filter(|p| !trusted(p) && p.std_dev_px <= size).copied();
        let prior = prior.filter(trusted);
        self.prior_known = prior.is_some();
        let (u, v, deviation) = prior.map_or((0.0, 0.0, 0.0), |p| (p.shift_u_px, p.shift_v_px, p.std_dev_px));
        self.camera_shift = (u as f32, v as f32);
        self.camera_known = self.prior_known;
        let density = config.agility * f64::from(self.size_px());
        self.motion.0.predict(seconds, density * density, u, deviation);
        self.motion.1.predict(seconds, density * density, v, deviation);
        seconds
    }

    /// Where it must be, in the picture: with the shift of the surroundings where one was measured.
    pub(super) fn expected(&mut self, shift: Option<(f32, f32)>) -> (f32, f32) {
        let rough = self.rough_prior.take();
        // Surroundings that seem to have gone elsewhere than the camera can have turned were mistaken.
        let believed = |(u, v): &(f32, f32)| {
            rough.is_none_or(|prior| {
                let off = libm::hypot(f64::from(*u) - prior.shift_u_px, f64::from(*v) - prior.shift_v_px);
                off <= BELIEVED_DEVIATIONS * prior.std_dev_px
            })
        };
        if let Some((u, v)) = shift.filter(believed) {
            self.motion.0.shift(f64::from(u), SHIFT_DEVIATION_SHARE * f64::from(self.size_px()));
            self.motion.1.shift(f64::from(v), SHIFT_DEVIATION_SHARE * f64::from(self.size_px()));
            self.camera_shift = (u, v);
            self.camera_known = true;
        } else if let Some(prior) = rough {
            self.motion.0.shift(prior.shift_u_px, prior.std_dev_px);
            self.motion.1.shift(prior.shift_v_px, prior.std_dev_px);
            self.camera_shift = (prior.shift_u_px as f32, prior.shift_v_px as f32);
        }
        let bounds = self.bounds();
        ((self.motion.0.place as f32).clamp(0.0, bounds.0), (self.motion.1.place as f32).clamp(0.0, bounds.1))
    }

    /// Whether the prediction lies in the picture.
    pub(super) fn predicted_inside(&self) -> bool {
        let bounds = self.bounds();
        (0.0..=f64::from(bounds.0)).contains(&self.motion.0.place)
            && (0.0..=f64::from(bounds.1)).contains(&self.motion.1.place)
    }

    /// Deviation of the prediction, pixels.
    pub(super) fn deviation(&self) -> f32 {
        self.motion.0.deviation().max(self.motion.1.deviation()) as f32
    }

    /// By what a look needs more evidence because it lies farther from the prediction than was to be expected: 1 to 2.
    pub(super) fn jump(&self, look: &Look) -> f32 {
        let (du, dv) =
            (f64::from(look.centre.0) - self.motion.0.place, f64::from(look.centre.1) - self.motion.1.place);
        let allowed = 3.0 * f64::from(self.deviation()) + 0.5 * f64::from(self.size_px());
        let beyond = libm::hypot(du, dv) / allowed - 1.0;
        (1.0 + 0.5 * beyond.clamp(0.0, 2.0)) as f32
    }

    /// How alike to it a look must show a thing to be, after it was lost. Where it vanished not long ago in the middle
    /// of the picture, it is most likely still there, and half hidden; a thing elsewhere must be like it in every
    /// respect.
    pub(super) fn alike_enough(&self, look: &Look) -> f32 {
        let away = libm::hypotf(look.centre.0 - self.vanished.place.0, look.centre.1 - self.vanished.place.1);
        let recent = self.last_at.since(self.vanished.at).as_secs_f64() <= STILL_THERE_S;
        let there = self.vanished.inside && recent && away <= STILL_THERE_SIZES * self.size_px();
        if there { STILL_THERE_ALIKE } else { ELSEWHERE_ALIKE }
    }

    /// Remembers where it was lost.
    pub(super) fn vanish(&mut self, inside: bool) {
        let place = (self.motion.0.place as f32, self.motion.1.place as f32);
        self.searched = 0;
        self.vanished = Vanished { at: self.last_at, place, inside };
        (self.scale, self.extent) = self.steady;
    }

    /// What was perhaps found again was something else.
    pub(super) fn dismiss(&mut self) {
        (self.scale, self.extent) = self.steady;
    }

    /// Goes on where the prediction says.
    pub(super) fn coast(&mut self) {
        let (u, v) = (self.motion.0.place as f32, self.motion.1.place as f32);
        self.centre = (u, v);
    }

    /// Goes on from a place where it was perhaps found again.
    pub(super) fn restart_at(&mut self, config: &FusedConfig, look: &Look) {
        self.rescale(look.place.step / self.place(config).step);
        self.axis = self.axis_at(&look.place);
        self.angle = look.place.angle;
        self.centre = look.centre;
        let size = f64::from(self.size_px());
        self.motion = (
            Axis::at(f64::from(look.centre.0), 0.1 * size, size),
            Axis::at(f64::from(look.centre.1), 0.1 * size, size),
        );
        self.heading.forget();
    }

    /// Takes bow for stern.
    pub(super) fn turn_about(&mut self) {
        self.angle += core::f32::consts::PI;
        self.axis += core::f32::consts::PI;
    }

    /// What is reported of it.
    pub(super) fn report(&self, frame: &VideoFrame) -> Localisation {
        let (w, h) = self.extent.upright(self.scale, self.axis);
        let (w, h) = (f64::from(w), f64::from(h));
        let (u, v) = (f64::from(self.centre.0), f64::from(self.centre.1));
        let bounds = PixelBox { u: u - 0.5 * w, v: v - 0.5 * h, w, h };
        self.localisation(frame, bounds.clipped(frame.picture.size()), self.confidence)
    }

    /// The middle of the hull: that of its box where no outline is known.
    ///
    /// As long as nothing tells the bow, it is taken to be halfway between the ends of its colour. These are wrong where
    /// bow or stern are painted otherwise, or where the wake has the colour, too. Once the bow is known, the middle
    /// follows from the operator's box, which holds all of the hull ([`Outline::astern`]).
    fn middle(&self) -> PixelPoint {
        let (u, v) = (f64::from(self.centre.0), f64::from(self.centre.1));
        let Some(outline) = &self.outline else {
            return PixelPoint { u, v };
        };
        let half = self.half_axes();
        let certain = self.heading.certainty() as f32;
        let ahead = certain * outline.astern - (1.0 - certain.abs()) * outline.box_offset.0;
        let (ahead, aside) =
            (ahead * 2.0 * half.0 / outline.length, -outline.box_offset.1 * 2.0 * half.1 / outline.breadth);
        let (c, s) = (libm::cosf(self.axis), libm::sinf(self.axis));
        PixelPoint { u: u + f64::from(ahead * c - aside * s), v: v + f64::from(ahead * s + aside * c) }
    }

    pub(super) fn localisation(&self, frame: &VideoFrame, bounds: PixelBox, confidence: f64) -> Localisation {
        let half = self.half_axes();
        let shape = self.extent.axis().map(|_| Shape {
            major_px: 2.0 * f64::from(half.0.max(half.1)),
            minor_px: 2.0 * f64::from(half.0.min(half.1)),
            axis: anticlockwise(self.axis, core::f64::consts::PI),
        });
        let bow = self.extent.axis().and_then(|_| self.heading.bow());
        let end = |ahead: bool| if ahead { self.axis } else { self.axis + core::f32::consts::PI };
        Localisation {
            captured: frame.capture.at,
            picture: frame.picture.size(),
            centre: self.middle(),
            bounds,
            shape,
            heading: bow.map(|ahead| anticlockwise(end(ahead), core::f64::consts::TAU)),
            confidence,
        }
    }
}

/// An angle clockwise from image right, as one anticlockwise from 0 (inclusive) to `period` (exclusive).
fn anticlockwise(clockwise: f32, period: f64) -> Angle {
    let turned = -f64::from(clockwise);
    let wrapped = turned - period * (turned / period).floor();
    // Rounding can make it the period itself.
    Angle::from_radians(if wrapped < period { wrapped } else { 0.0 })
}

/// The search window is at least this many times as long as the target.
const LEAST_WINDOW_SIZES: f32 = 2.0;
/// And at least that many pixels: more than the filter can resolve is not gained by looking closer.
const LEAST_WINDOW_PX: f32 = 24.0;
/// A longer time between two frames tells no more than this one, seconds.
const LONGEST_GAP_S: f64 = 2.0;
/// A prior that speaks of more pixels than this is none.
const MOST_SHIFT_PX: f64 = 1.0e6;
/// A prior that knows the shift no better than this is used only where the surroundings show none, pixels.
const TRUSTED_DEVIATION_PX: f64 = 1.5;
/// The surroundings are believed within so many deviations of such a prior.
const BELIEVED_DEVIATIONS: f64 = 4.0;
/// How well the surroundings tell the camera's motion, in sizes of the target.
const SHIFT_DEVIATION_SHARE: f64 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recognition_is_the_mean_of_its_looks() {
        let first = Recognition::default().with(2.5);
        assert_eq!(first, Recognition { looks: 1, alike: 2.5 });
        let third = first.with(2.25).with(2.0);
        assert!((third.alike - 2.25).abs() < 1e-6 && third.looks == 3, "{third:?}");
    }
}
