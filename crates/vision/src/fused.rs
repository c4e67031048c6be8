//! The tracker that is used unless another is asked for: two opinions of each frame, and the honesty to say "lost".
//!
//! One opinion is a correlation filter on gradients, brightness and the likeness of the colour, confined to the
//! target and its close surroundings (`correlation`). The other is the colour alone: how much more the target's place
//! has of the target's colours than the ring around it (`colour_model`). Their sum, the *evidence*, counts in
//! deviations of the filter's sidelobes; where the target's colour is like its surroundings', the colour has no say.
//!
//! A frame goes through these steps:
//!
//! 1. *predict*: a Kalman filter in pixel coordinates says where the target must be. The camera's own motion comes
//!    from the [`MotionPrior`]; without one it is measured in the picture (`background`).
//! 2. *look*: the search window is taken at the coarsest resolution that the target's size allows, turned and scaled as
//!    the target was (`crop`, `features`), and the filter's response is searched for its peak. Where the prediction
//!    is worse than the window is wide, the windows around it are looked at, too.
//! 3. *judge*: from the evidence follow the state (`phase`) and the confidence (`evidence`).
//! 4. *refine*: other sizes and turns are tried by the filter's response at one place, the moments of the colour
//!    correct place and axis (`silhouette`), the path tells the bow from the stern (`heading`).
//! 5. *learn*: filter and histograms take the frame in, only where the evidence is good.
//!
//! A lost target is searched for by colour over the whole picture (`redetection`) and by the filter where it was
//! last and, a window per frame, everywhere; what is found must be seen again in the frames that follow before it is
//! reported.
//!
//! Work per frame: that of one search window of at most 130 x 130 samples and about nine small patches, whatever the
//! target's size; at most eight search windows while it is lost. Memory: under 2 MiB, none allocated per frame once
//! the buffers have their size.
//!
//! Not handled: targets that change beyond recognition while they are hidden, flocks of alike targets that cross,
//! targets under about 6 pixels.

mod config;
mod evidence;
mod extent;
mod learning;
mod phase;
mod recovery;
mod refining;
mod target;

use barrelman_vocab::{MotionPrior, Picture, PixelBox, Track, VideoFrame};

pub use self::config::{FusedConfig, FusedConfigError};
use self::evidence::{Look, confidence, confidence_disbelieved, confidence_unseen};
use self::phase::{Phase, Sight};
use self::target::Target;
use crate::background::Background;
use crate::colour_model::Histogram;
use crate::correlation::Peak;
use crate::crop::Crop;
use crate::explanation::{Explanation, GreyMap, Stage};
use crate::features::{Features, Place};
use crate::fourier::{AREA, Map, SIDE, Spectrum};
use crate::gradients::CELL;
use crate::layout::Layout;
use crate::redetection::Redetection;
use crate::tracker::{SelectionError, SelectionReport, Tracker};
use crate::window::{Window, reaches_out};

/// Follows a target by what it looks like and by its colour.
#[derive(Debug)]
pub struct FusedTracker {
    config: FusedConfig,
    eyes: Eyes,
    target: Option<Target>,
}

/// Everything that looks at a picture, and the room it works in.
#[derive(Debug)]
struct Eyes {
    crop: Crop,
    features: Features,
    spectrum: Spectrum,
    response: Box<Map>,
    redetection: Redetection,
    background: Background,
    /// Colours of the target and around it in one frame.
    colours: [Histogram; 2],
    /// Where on the target they lie.
    layout: Layout,
    /// What was looked at last.
    place: Place,
}

impl FusedTracker {
    /// A tracker with nothing selected.
    ///
    /// # Errors
    /// If a setting lies outside its range.
    pub fn new(config: FusedConfig) -> Result<Self, FusedConfigError> {
        let config = config.validated()?;
        let eyes = Eyes {
            crop: Crop::default(),
            features: Features::new(config.brightness_gain as f32, config.colour_gain as f32),
            spectrum: Spectrum::default(),
            response: Box::new([0.0; AREA]),
            redetection: Redetection::default(),
            background: Background::new(),
            colours: [Histogram::default(), Histogram::default()],
            layout: Layout::default(),
            place: Place { centre: (0.0, 0.0), step: 1.0, angle: 0.0 },
        };
        Ok(Self { config, eyes, target: None })
    }

    /// Its settings.
    pub const fn config(&self) -> &FusedConfig {
        &self.config
    }
}

impl Tracker for FusedTracker {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        let picture = frame.picture.size();
        let window = Window::of_selection(selection, picture)?;
        let used = window.in_pixels();
        let (target, likeness) = self.eyes.learn_selection(&self.config, frame, used);
        let localisation = target.localisation(frame, used, 1.0);
        self.target = Some(target);
        Ok(SelectionReport {
            used,
            clipped: reaches_out(selection, picture),
            coloured: likeness.coloured,
            surroundings: likeness.surroundings,
            localisation,
        })
    }

    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        let Some(target) = &mut self.target else {
            return Track::Unseeded;
        };
        self.eyes.advance(&self.config, target, frame, prior)
    }

    fn explain(&self, out: &mut Explanation) {
        out.clear();
        let Some(target) = &self.target else {
            return;
        };
        let place = self.eyes.place;
        let side = f64::from(place.side());
        let corner = |middle: f32| f64::from(middle) - 0.5 * side;
        let window = PixelBox { u: corner(place.centre.0), v: corner(place.centre.1), w: side, h: side };
        out.search_window = Some(window);
        out.response.bounds = window;
        self.eyes.crop.explain_likeness(&mut out.back_projection);
        explain_response(&self.eyes.response, place.angle, &mut out.response);
        out.stage = Some(match target.phase {
            Phase::Seen => Stage::Tracking,
            Phase::Coasting { .. } => Stage::Coasting,
            Phase::Lost { .. } => Stage::Lost,
            Phase::Confirming { .. } => Stage::Confirming,
        });
        out.confidence = target.confidence;
    }
}

/// The samples of the response around the middle of a search window that was turned by `angle`, upright, 0 to 255.
fn explain_response(response: &Map, angle: f32, out: &mut GreyMap) {
    (out.width, out.height) = (SIDE, SIDE);
    let highest = response.iter().fold(f32::MIN_POSITIVE, |highest, &value| highest.max(value));
    let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
    let middle = (SIDE / 2) as f32;
    out.samples.extend((0..AREA).map(|index| {
        // The window is turned; the map that is shown is not.
        let (right, down) = ((index % SIDE) as f32 + 0.5 - middle, (index / SIDE) as f32 + 0.5 - middle);
        let (column, row) = (right * cos + down * sin, down * cos - right * sin);
        let wrapped = |shift: f32| (shift.floor() as i32).rem_euclid(SIDE as i32) as usize;
        (255.0 * response[wrapped(row) * SIDE + wrapped(column)] / highest).clamp(0.0, 255.0) as u8
    }));
}

impl Eyes {
    /// One frame.
    fn advance(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        frame: &VideoFrame,
        prior: Option<&MotionPrior>,
    ) -> Track {
        let picture = &*frame.picture;
        let now = frame.capture.at;
        target.turn_to(picture.size(), &mut self.background);
        let seconds = target.predict(config, now, prior);
        let sight = match target.phase {
            Phase::Lost { .. } => {
                let found = self.search_everywhere(config, target, picture);
                if let Some(look) = &found {
                    target.restart_at(config, look);
                }
                if found.is_some() { Sight::Seen } else { Sight::Unseen }
            }
            _ => self.follow(config, target, frame, seconds),
        };
        let before = target.phase;
        target.phase = before.after(sight, now, config.coast_s, config.confirm);
        if matches!(target.phase, Phase::Lost { .. })
            && matches!(before, Phase::Seen | Phase::Coasting { .. })
        {
            target.vanish(sight != Sight::Gone);
        } else if matches!(target.phase, Phase::Lost { .. }) && matches!(before, Phase::Confirming { .. }) {
            target.dismiss();
        }
        match target.phase {
            Phase::Seen => Track::Tracking(target.report(frame)),
            Phase::Coasting { since } => {
                target.coast();
                target.confidence = confidence_unseen(now.since(since).as_secs_f64());
                Track::Coasting(target.report(frame))
            }
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                Track::Lost { since, confidence: target.confidence }
            }
        }
    }

    /// Looks where the target must be.
    fn follow(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        frame: &VideoFrame,
        seconds: f64,
    ) -> Sight {
        let picture = &*frame.picture;
        let mut look = self.look_around(config, target, picture);
        if matches!(target.phase, Phase::Confirming { .. }) {
            look = self.better_way_round(config, target, picture, look);
        }
        let needed = if target.phase == Phase::Seen { 1.0 } else { STRICTER };
        let jump = target.jump(&look);
        let evidence = look.evidence(config, target);
        let believed = !matches!(target.phase, Phase::Confirming { .. })
            || self.still_recognises(config, target, picture, &look);
        if evidence < config.seen as f32 * needed * jump || !believed || look.colour_gone(target) {
            target.confidence = confidence_disbelieved(&look, target);
            self.background.forget();
            return if target.predicted_inside() { Sight::Unseen } else { Sight::Gone };
        }
        target.confidence = confidence(&look, target);
        self.refine(config, target, &look, frame, seconds);
        let like_itself = look.colour(target).is_none_or(|share| share >= LEARNED_COLOUR);
        let well_seen = evidence >= config.learn as f32 * jump && like_itself;
        if target.phase == Phase::Seen && well_seen && !target.touches_border() {
            self.learn(config, target, picture, &look);
        }
        Sight::Seen
    }

    /// Looks at the window around the prediction, and at those beside it where the prediction is too uncertain.
    fn look_around(&mut self, config: &FusedConfig, target: &mut Target, picture: &Picture) -> Look {
        let place = target.place(config);
        let side = place.side();
        let shift = self.shift_of_background(target, picture);
        let place = Place { centre: target.expected(shift), ..place };
        let mut best = self.look(target, picture, place);
        if 2.0 * target.deviation() > UNCERTAIN * side && best.evidence(config, target) < config.learn as f32
        {
            for (right, down) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                let centre = (place.centre.0 + 0.5 * right * side, place.centre.1 + 0.5 * down * side);
                let look = self.look(target, picture, Place { centre, ..place });
                if look.evidence(config, target) > best.evidence(config, target) {
                    best = look;
                }
            }
            if best.place != self.place {
                // What comes after samples the crop of the best look.
                best = self.look(target, picture, best.place);
            }
        }
        best
    }

    /// Looks once with the filter.
    fn look(&mut self, target: &Target, picture: &Picture, place: Place) -> Look {
        self.take(target, picture, &place);
        let bounds = target.bounds();
        self.features.measure(&mut self.crop, &place, bounds);
        target.filter.respond(&self.features.spectra, &mut self.spectrum);
        self.features.fourier.inverse(&self.spectrum, &mut self.response);
        let peak = Peak::of(&self.response);
        let (u, v) = place.point(peak.right * CELL as f32, peak.down * CELL as f32);
        let centre = (u.clamp(0.0, bounds.0), v.clamp(0.0, bounds.1));
        let (inside, ring) = self.crop.contrast(centre, target.half_axes(), target.axis_at(&place));
        self.place = place;
        Look { place, centre, peak, inside, ring }
    }

    fn take(&mut self, target: &Target, picture: &Picture, place: &Place) {
        let turn = libm::cosf(place.angle).abs() + libm::sinf(place.angle).abs();
        let reach = 0.5 * place.step * (SIDE * CELL + 2) as f32 * turn * WINDOW_MARGIN;
        self.crop.take(picture, &target.colours, place.centre, reach, place.step);
    }

    /// How the surroundings shifted since the last frame, where no prior said so.
    fn shift_of_background(&mut self, target: &Target, picture: &Picture) -> Option<(f32, f32)> {
        if target.prior_known {
            return None;
        }
        self.background.shift(picture.y(), &mut self.features.fourier)
    }
}

/// What a target that was not seen in the last frame must have more evidence by.
const STRICTER: f32 = 1.0;
/// With less of the usual contrast of its colour than this, a frame is not learned from: the target may be hidden.
const LEARNED_COLOUR: f32 = 0.15;
/// Beyond this share of the search window's side, two deviations of the prediction are too much for one window.
const UNCERTAIN: f32 = 0.4;
/// The crop is larger than the search window by this factor, for the patch that is learned afterwards.
const WINDOW_MARGIN: f32 = 1.15;
