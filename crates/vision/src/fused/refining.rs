//! Size, turn, place and direction of a target that was seen.

use barrelman_vocab::{Picture, VideoFrame};

use super::Eyes;
use super::config::FusedConfig;
use super::evidence::Look;
use super::target::Target;
use crate::correlation::parabola;
use crate::features::Place;
use crate::silhouette::Silhouette;

/// Deviation of a measured place, in sizes of the target.
const PLACE_DEVIATION: f64 = 0.05;
/// Within this time the axis follows the silhouette's, seconds.
const AXIS_S: f64 = 0.15;
/// Within this time the place follows the silhouette's, seconds.
const PLACE_S: f64 = 0.3;
/// Within this time the size follows the silhouette's, seconds.
const SIZE_S: f64 = 1.0;
/// The silhouette is looked for in the target's ellipse, this many times as large.
const SILHOUETTE_REACH: f32 = 1.35;
/// A silhouette whose length or breadth differs by more than this factor is of something else, too.
const MISFIT: f32 = 1.5;

impl Eyes {
    /// Measures the target where it was just seen and takes it in.
    pub(super) fn refine(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        look: &Look,
        frame: &VideoFrame,
        seconds: f64,
    ) {
        let bounds = target.bounds();
        let before = target.centre;
        let place = Place { centre: look.centre, ..look.place };
        let middle = self.features.score(&mut self.crop, &place, &target.filter, target.reach, bounds);
        let gain = config.change_gain as f32;
        let rung = self.best_rung(target, bounds, middle, gain, |rung| Place {
            step: place.step * libm::powf(config.scale_step as f32, rung),
            ..place
        });
        let turn_step = config.turn_step_deg.to_radians() as f32;
        let turn = self.best_rung(target, bounds, middle, gain, |rung| Place {
            angle: place.angle + rung * turn_step,
            ..place
        });
        target.centre = look.centre;
        // Of a target that is partly out of the picture, size and turn cannot be told.
        if !target.touches_border() {
            target.rescale(libm::powf(config.scale_step as f32, rung));
            target.angle += turn * turn_step;
            target.axis += turn * turn_step;
            self.follow_silhouette(target, look, seconds as f32);
            self.come_back(config, target, &frame.picture);
        }

        let size = f64::from(target.size_px());
        target.motion.0.correct(f64::from(target.centre.0), PLACE_DEVIATION * size);
        target.motion.1.correct(f64::from(target.centre.1), PLACE_DEVIATION * size);
        let (du, dv) = (
            target.centre.0 - before.0 - target.camera_shift.0,
            target.centre.1 - before.1 - target.camera_shift.1,
        );
        let length = 2.0 * f64::from(target.half_axes().0.max(target.half_axes().1));
        let moved = (f64::from(du), f64::from(dv));
        if target.camera_known {
            let at_s = frame.capture.at.as_secs_f64();
            target.heading.moved(at_s, seconds, moved, f64::from(target.axis), length);
        } else {
            target.heading.interrupt();
        }
        if !target.prior_known {
            let (centre, blank) = (target.centre, target.blank());
            self.background.remember(frame.picture.y(), &mut self.features.fourier, centre, blank);
        }
    }

    /// Which of some changes fits best, in steps, between steps by a parabola; 0 unless another is clearly better.
    fn best_rung(
        &mut self,
        target: &Target,
        bounds: (f32, f32),
        middle: f32,
        gain: f32,
        place_of: impl Fn(f32) -> Place,
    ) -> f32 {
        let mut score = |rung: f32| {
            gain * self.features.score(&mut self.crop, &place_of(rung), &target.filter, target.reach, bounds)
        };
        let (below, above) = (score(-1.0), score(1.0));
        if below <= middle && above <= middle {
            return parabola(below, middle, above);
        }
        // One step is better: perhaps two are.
        let (side, near) = if above > below { (1.0, above) } else { (-1.0, below) };
        let far = score(2.0 * side);
        if far > near { 2.0 * side } else { side * (1.0 + parabola(middle, near, far)) }
    }

    /// Lets the moments of the colour correct what drifts: axis, place, length and breadth.
    fn follow_silhouette(&mut self, target: &mut Target, look: &Look, seconds: f32) {
        let Some(outline) = target.outline else { return };
        let (along, across) = target.half_axes();
        let half = (SILHOUETTE_REACH * along, SILHOUETTE_REACH * across);
        let Some(seen) =
            Silhouette::of(&self.crop, target.centre, half, target.axis, (look.inside, look.ring))
        else {
            return;
        };
        let (longer, wider) = outline.stretch_of(&seen);
        let (long, wide) = (outline.length * longer, outline.breadth * wider);
        let fits = |measured: f32, known: f32| (1.0 / MISFIT..=MISFIT).contains(&(measured / known));
        if !(fits(long, 2.0 * along) && fits(wide, 2.0 * across)) || target.touches_border() {
            return;
        }
        let share = |time_s: f64| (1.0 - libm::exp(-f64::from(seconds) / time_s)) as f32;
        // The clearer the axis, the more it counts.
        let clear = (1.0 - seen.roundness()).clamp(0.0, 1.0);
        target.axis += share(AXIS_S) * clear * half_turn_apart(seen.axis, target.axis);
        let (c, s) = (libm::cosf(target.axis), libm::sinf(target.axis));
        let (ahead, aside) = (outline.offset.0 * longer, outline.offset.1 * wider);
        let centre = (seen.centroid.0 + ahead * c - aside * s, seen.centroid.1 + ahead * s + aside * c);
        let part = share(PLACE_S);
        target.centre.0 += part * (centre.0 - target.centre.0);
        target.centre.1 += part * (centre.1 - target.centre.1);
        target.stretch_to(long, wide, share(SIZE_S));
    }
}

impl Eyes {
    /// Brings a box back that slipped off its target while the filter learned along.
    ///
    /// The filter and the silhouette both look where the target is taken to be: once the box covers a part of it, or
    /// its wake, they agree with each other on that. So now and then the blob of colour is followed to where it ends,
    /// beginning with the box. Where the box stands out from its surroundings much less than that blob does, several
    /// times in a row, the blob is the target, and the filter is taught anew. A thing of its colour beside the target
    /// does not count: the target's own box stands out as before.
    fn come_back(&mut self, config: &FusedConfig, target: &mut Target, picture: &Picture) {
        target.refined = target.refined.wrapping_add(1);
        if !target.refined.is_multiple_of(BLOB_EVERY) {
            return;
        }
        let (inside, ring) = self.crop.contrast(target.centre, target.half_axes(), target.axis);
        let slipped = |(_, stands_out): &(Silhouette, f32)| inside - ring < SLIPPED * stands_out;
        let Some((seen, _)) = self.blob(target, ring).filter(slipped) else {
            target.astray = 0;
            return;
        };
        target.astray += 1;
        if target.astray < ASTRAY_BLOBS {
            return;
        }
        target.astray = 0;
        target.axis += half_turn_apart(seen.axis, target.axis);
        target.centre = seen.centroid;
        // Where nothing is known of how the colour fills the hull, it is taken to fill it.
        let (long, wide) = target.outline.map_or((seen.major, seen.minor), |outline| {
            let (longer, wider) = outline.stretch_of(&seen);
            (outline.length * longer, outline.breadth * wider)
        });
        target.stretch_to(long, wide, 1.0);
        let place = target.place(config);
        self.teach(target, picture, place);
    }

    /// The blob of the target's colour that begins in its box, and how much it stands out; none where nothing stands out
    /// from the likeness around the box.
    fn blob(&self, target: &Target, ring: f32) -> Option<(Silhouette, f32)> {
        let (along, across) = target.half_axes();
        let least = BLOB_LEAST_PX;
        let mut centre = target.centre;
        let mut half = ((2.0 * along).max(least), (2.0 * along.max(across)).max(least));
        let mut angle = target.axis;
        let mut found: Option<Silhouette> = None;
        for _ in 0..BLOB_STEPS {
            let seen = Silhouette::of(&self.crop, centre, half, angle, (BLOB_LIKENESS, ring))?;
            centre = seen.centroid;
            half = (
                (0.5 * SILHOUETTE_REACH * seen.major).max(least),
                (0.5 * SILHOUETTE_REACH * seen.minor).max(least),
            );
            angle = seen.axis;
            found = Some(seen);
        }
        let seen = found?;
        let (inside, ring) =
            self.crop.contrast(seen.centroid, (0.5 * seen.major, 0.5 * seen.minor), seen.axis);
        (inside - ring >= BLOB_CONTRAST).then_some((seen, inside - ring))
    }
}

/// The blob is looked for in each so many frames in which the target is seen ...
const BLOB_EVERY: u32 = 8;
/// ... in so many steps, from ellipses no smaller than this on, pixels ...
const BLOB_STEPS: usize = 5;
const BLOB_LEAST_PX: f32 = 6.0;
/// ... among what is nearer to this likeness than to that around the box, ...
const BLOB_LIKENESS: f32 = 0.95;
/// ... and is one only if it stands out so far.
const BLOB_CONTRAST: f32 = 0.4;
/// A box slipped off that stands out by less than this share of what the blob does, ...
const SLIPPED: f32 = 0.6;
/// ... so many times in a row.
const ASTRAY_BLOBS: u32 = 4;

/// From one axis to another, -pi/2 to pi/2.
fn half_turn_apart(to: f32, from: f32) -> f32 {
    let pi = core::f32::consts::PI;
    let turns = (to - from) / pi;
    (turns - (turns + 0.5).floor()) * pi
}
