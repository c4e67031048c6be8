//! What the filter and the colours learn: all of the selection, a little of every good frame.

use barrelman_vocab::{Picture, PixelBox, VideoFrame};

use super::Eyes;
use super::config::FusedConfig;
use super::evidence::Look;
use super::extent::Extent;
use super::phase::Phase;
use super::target::{Outline, Recognition, Target, Vanished};
use crate::colour_model::{ColourModel, Region, count_colours};
use crate::correlation::{CorrelationFilter, wanted_response};
use crate::features::Place;
use crate::fourier::{AREA, Map, SIDE, Spectrum};
use crate::gradients::CELL;
use crate::heading::Heading;
use crate::layout::Layout;
use crate::motion::Axis;
use crate::silhouette::Silhouette;

/// Steps of the filter's solution at the selection, and for each frame, which goes on from the last.
const FIRST_STEPS: usize = 6;
const STEPS: usize = 2;
/// The colours are counted again in each so many frames that are learned from.
const COLOUR_EVERY: u32 = 4;
/// Colour adapts only where it is still the target's: least share of the usual contrast.
const OWN_COLOUR: f32 = 0.6;
/// What is usual follows within about twenty frames.
const USUAL_RATE: f32 = 0.05;
/// The same for the likeness of the colours, which is measured in each fourth frame only.
const KINSHIP_RATE: f32 = 0.15;
/// A first guess of the colours' usual likeness.
const FIRST_KINSHIP: f32 = 0.95;
/// A first guess of the response's usual height.
const FIRST_HEIGHT: f32 = 0.7;
/// A silhouette is trusted to say later how large the target is and which way it lies if at the selection it stood
/// out by this much, ...
const TRUSTED_CONTRAST: f32 = 0.5;
/// ... its upright box was the operator's to within this factor, ...
const TRUSTED_STRETCH: f32 = 1.25;
/// ... and it filled this share of the ellipse.
const TRUSTED_FILL: f32 = 0.5;
/// The upright box around a hull that lies askew touches the point of its bow at one corner and the corners of its blunt
/// stern on two sides, so that its middle lies astern of the hull's, by
/// ([`BLUNT`] + [`BLUNTER`] |cos sin|) |cos sin| breadths with the cosine and sine of its axis: to within 0.02 breadths, for
/// hulls two to five times as long as wide whose bow tapers off from the middle on, slender or full.
const BLUNT: f32 = 0.22;
const BLUNTER: f32 = 0.34;
/// Likeness from which on a pixel counts as coloured like the target.
const COLOURED: u8 = 128;

/// What a selection's colours are worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SelectionColours {
    /// Share of the selection's pixels that are rather the target's colour than the surroundings', 0 to 1.
    pub(super) coloured: f64,
    /// Mean likeness around it, 0 to 1.
    pub(super) surroundings: f64,
}

impl Eyes {
    /// A target from a box on a frame.
    pub(super) fn learn_selection(
        &mut self,
        config: &FusedConfig,
        frame: &VideoFrame,
        used: PixelBox,
    ) -> (Target, SelectionColours) {
        let picture = &*frame.picture;
        let middle = used.centre();
        let centre = (middle.u as f32, middle.v as f32);
        let (width, height) = (used.w as f32, used.h as f32);
        let size = (width * height).sqrt();
        let mut colours = ColourModel::default();
        let region = Region::upright((width, height));
        count_colours(picture, centre, &region, &mut colours.target, &mut colours.surroundings);
        colours.renew();
        let speed = 2.0 * f64::from(size);
        let mut target = Target {
            phase: Phase::Seen,
            extent: Extent::Box { width, height },
            size,
            scale: 1.0,
            angle: 0.0,
            axis: 0.0,
            centre,
            outline: None,
            motion: (Axis::at(middle.u, 1.0, speed), Axis::at(middle.v, 1.0, speed)),
            prior_known: false,
            rough_prior: None,
            refined: 0,
            astray: 0,
            camera_known: false,
            camera_shift: (0.0, 0.0),
            heading: Heading::default(),
            picture: picture.size(),
            last_at: frame.capture.at,
            colours,
            filter: CorrelationFilter::default(),
            wanted: Spectrum::default(),
            mask: Box::new([0.0; AREA]),
            reach: (0, 0),
            contrast: 0.0,
            kinship: FIRST_KINSHIP,
            layout: Layout::default(),
            layout_kinship: FIRST_KINSHIP,
            height: FIRST_HEIGHT,
            learned: 0,
            vanished: Vanished { at: frame.capture.at, place: centre, inside: false },
            recognition: Recognition::default(),
            steady: (1.0, Extent::Box { width, height }),
            searched: 0,
            scan: 0,
            confidence: 1.0,
        };
        let place = target.place(config);
        self.take(&target, picture, &place);
        let report = self.judge_colours(&mut target, (width, height));
        // The extent may have changed the window.
        let place = target.place(config);
        let cell = place.step * CELL as f32;
        target.wanted =
            wanted_response(&mut self.features.fourier, config.response_deviation as f32 * size / cell);
        let half = (0.5 * config.mask as f32 * width / cell, 0.5 * config.mask as f32 * height / cell);
        target.mask = mask(half);
        target.reach = (half.0.ceil() as usize, half.1.ceil() as usize);
        self.teach(&mut target, picture, place);
        self.background.remember(picture.y(), &mut self.features.fourier, centre, target.blank());
        (target, report)
    }

    /// Teaches the filter, and where which colours lie, from nothing but what is at a place now.
    pub(super) fn teach(&mut self, target: &mut Target, picture: &Picture, place: Place) {
        self.take(target, picture, &place);
        self.place = place;
        self.features.measure(&mut self.crop, &place, target.bounds());
        target.filter.learn(&self.features.spectra, 1.0);
        for _ in 0..FIRST_STEPS {
            target.filter.improve(&mut self.features.fourier, &target.wanted, &target.mask);
        }
        target.layout.count(picture, target.centre, target.half_axes(), target.axis);
    }

    /// How distinct the colours are, and what they say of the target's outline.
    fn judge_colours(&mut self, target: &mut Target, box_size: (f32, f32)) -> SelectionColours {
        let half = (0.5 * box_size.0, 0.5 * box_size.1);
        let (inside, ring) = self.crop.contrast(target.centre, half, 0.0);
        // A corner of the box is 1.41 half sides away from its middle.
        let all = (1.42 * half.0, 1.42 * half.1);
        let (mut coloured, mut count) = (0_u32, 0_u32);
        self.crop.each_likeness(target.centre, all, 0.0, |du, dv, likeness| {
            if du.abs() <= half.0 && dv.abs() <= half.1 {
                coloured += u32::from(likeness >= COLOURED);
                count += 1;
            }
        });
        let silhouette = Silhouette::of(&self.crop, target.centre, all, 0.0, (inside, ring)).filter(|seen| {
            let own = (0.5 * seen.major, 0.5 * seen.minor);
            let (inside, ring) = self.crop.contrast(seen.centroid, own, seen.axis);
            inside - ring >= TRUSTED_CONTRAST
        });
        target.extent = Extent::of_selection(box_size, silhouette.as_ref());
        target.steady = (1.0, target.extent);
        target.axis = target.extent.axis().unwrap_or(0.0);
        if let (Some(seen), Extent::Hull { length, breadth, stretch, .. }) = (silhouette, target.extent) {
            let (c, s) = (libm::cosf(target.axis), libm::sinf(target.axis));
            let off = |from: (f32, f32)| {
                let (right, down) = (target.centre.0 - from.0, target.centre.1 - from.1);
                (right * c + down * s, down * c - right * s)
            };
            let outline = Outline {
                offset: off(seen.centroid),
                box_offset: off(seen.middle),
                astern: (BLUNT + BLUNTER * (c * s).abs()) * breadth * (c * s).abs(),
                major: seen.major,
                minor: seen.minor,
                length,
                breadth,
            };
            let square = |stretch: f32| (1.0 / TRUSTED_STRETCH..=TRUSTED_STRETCH).contains(&stretch);
            let filled = seen.area / (0.25 * core::f32::consts::PI * length * breadth);
            let trusted = square(stretch.0) && square(stretch.1) && filled >= TRUSTED_FILL;
            target.outline = trusted.then_some(outline);
        }
        let (inside, ring) = self.crop.contrast(target.centre, target.half_axes(), target.axis);
        target.contrast = inside - ring;
        SelectionColours {
            coloured: if count == 0 { 0.0 } else { f64::from(coloured) / f64::from(count) },
            surroundings: f64::from(ring),
        }
    }

    /// Learns a little from a frame in which the target was well seen.
    pub(super) fn learn(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        look: &Look,
    ) {
        let place = target.place(config);
        self.features.measure(&mut self.crop, &place, target.bounds());
        target.filter.learn(&self.features.spectra, config.learning_rate as f32);
        for _ in 0..STEPS {
            target.filter.improve(&mut self.features.fourier, &target.wanted, &target.mask);
        }
        target.height += USUAL_RATE * (look.peak.height.clamp(0.0, 1.0) - target.height);
        let own = look.colour(target).is_none_or(|share| share >= OWN_COLOUR);
        if own {
            target.contrast += USUAL_RATE * (look.inside - look.ring - target.contrast);
        }
        target.steady = (target.scale, target.extent);
        target.learned = target.learned.wrapping_add(1);
        if own && config.colour_rate > 0.0 && target.learned.is_multiple_of(COLOUR_EVERY) {
            let [inside, around] = &mut self.colours;
            let region = target.extent.region(target.scale, target.axis);
            count_colours(picture, target.centre, &region, inside, around);
            target.kinship += KINSHIP_RATE * (inside.overlap(&target.colours.target) - target.kinship);
            target.colours.target.blend(inside, config.colour_rate as f32);
            // Waters change faster than paint.
            target.colours.surroundings.blend(around, 2.0 * config.colour_rate as f32);
            target.colours.renew();
            self.layout.count(picture, target.centre, target.half_axes(), target.axis);
            target.layout_kinship +=
                KINSHIP_RATE * (self.layout.overlap(&target.layout) - target.layout_kinship);
            target.layout.blend(&self.layout, config.colour_rate as f32);
        }
    }
}

/// A box around the middle of half sides given in cells, its edge softened over one cell.
fn mask(half: (f32, f32)) -> Box<Map> {
    let mut map: Box<Map> = Box::new([0.0; AREA]);
    for (index, value) in map.iter_mut().enumerate() {
        let from_middle = |k: usize| ((k as f32) + 0.5 - (SIDE / 2) as f32).abs();
        let within = |half: f32, distance: f32| (half + 0.5 - distance).clamp(0.0, 1.0);
        *value = within(half.0, from_middle(index % SIDE)) * within(half.1, from_middle(index / SIDE));
    }
    map
}
