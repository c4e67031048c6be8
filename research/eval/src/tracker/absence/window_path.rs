//! The path of the window that is cropped from a clip: it follows the target, slides aside until the target
//! is out of the window, rests there, and slides back.

use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{PictureSize, PixelBox, PixelPoint};

use super::target_path::TargetPath;

/// How many times the target leaves.
pub(super) const EXCURSIONS: usize = 2;

/// Time before, between and after the excursions, seconds: enough to tell whether the target was found.
const IN_VIEW_S: f64 = 3.0;

/// Shortest and longest time for which the window rests aside, seconds.
const AWAY_S: (f64, f64) = (3.0, 7.5);

/// Mean speed of the window's slide, pixels per second, and its least duration, seconds.
const SLIDE_PX_PER_S: f64 = 250.0;
const MIN_SLIDE_S: f64 = 1.0;

/// While the window follows the target, it oscillates by this share of its sides with this period, seconds.
const OSCILLATION: f64 = 0.08;
const OSCILLATION_PERIOD_S: f64 = 5.0;

/// Least distance of the target from the window that rests aside, and from distractors, pixels.
pub(super) const MIN_DISTANCE_PX: f64 = 6.0;

/// An excursion of the target from the window: the window slides aside and back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Excursion {
    start_s: f64,
    slide_s: f64,
    away_s: f64,
    /// The window's upper left corner while it rests aside.
    pub(super) resting_corner: PixelPoint,
}

impl Excursion {
    fn end_s(&self) -> f64 {
        self.start_s + 2.0 * self.slide_s + self.away_s
    }

    /// How far the window is aside, 0 to 1, with smooth starts and ends.
    fn share_aside(&self, time_s: f64) -> f64 {
        let out = (time_s - self.start_s) / self.slide_s;
        let back = (self.end_s() - time_s) / self.slide_s;
        let share = out.min(back).clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    }

    /// The middle of the time for which the window rests aside, seconds.
    #[cfg(test)]
    pub(super) fn middle_s(&self) -> f64 {
        self.start_s + self.slide_s + self.away_s / 2.0
    }
}

/// The path of the window.
pub(super) struct WindowPath {
    pub(super) target: TargetPath,
    /// Size of the clip's pictures.
    pub(super) picture: PictureSize,
    pub(super) window: PictureSize,
    pub(super) excursions: Vec<Excursion>,
    /// Phase of the oscillation, radians.
    phase: f64,
}

impl WindowPath {
    /// Plans a path; `None` where the target cannot be left out of the window, or is not wholly visible at
    /// the start.
    pub(super) fn plan(
        target: TargetPath,
        picture: PictureSize,
        window: PictureSize,
        rng: &mut SplitMix64,
    ) -> Option<Self> {
        let phase = rng.between(0.0, std::f64::consts::TAU);
        let mut path = Self { target, picture, window, excursions: Vec::new(), phase };
        for _ in 0..EXCURSIONS {
            let excursion = path.nearest_excursion(rng.between(AWAY_S.0, AWAY_S.1))?;
            path.excursions.push(excursion);
        }
        // The operator selects a target that is wholly in the picture.
        (path.visible_share(0.0) >= 1.0).then_some(path)
    }

    /// The next excursion, with the shortest slide to a corner or to the middle of a side that leaves the
    /// target out.
    fn nearest_excursion(&self, away_s: f64) -> Option<Excursion> {
        let start_s = self.duration_s();
        let from = self.following_corner(start_s);
        let max = self.max_corner();
        let mut nearest: Option<(f64, Excursion)> = None;
        // Place 4 of the three by three is the middle of the picture.
        for place in (0..9).filter(|place| *place != 4) {
            let resting_corner =
                PixelPoint { u: max.u * f64::from(place % 3) / 2.0, v: max.v * f64::from(place / 3) / 2.0 };
            let slide_px = (resting_corner.u - from.u).hypot(resting_corner.v - from.v);
            let slide_s = (slide_px / SLIDE_PX_PER_S).max(MIN_SLIDE_S);
            let excursion = Excursion { start_s, slide_s, away_s, resting_corner };
            let is_nearer = nearest.is_none_or(|(nearest_px, _)| slide_px < nearest_px);
            if self.leaves_target_out(&excursion) && is_nearer {
                nearest = Some((slide_px, excursion));
            }
        }
        nearest.map(|(_, excursion)| excursion)
    }

    /// Whether the target stays out of the window while the window rests aside.
    fn leaves_target_out(&self, excursion: &Excursion) -> bool {
        let window = PixelBox {
            u: excursion.resting_corner.u - MIN_DISTANCE_PX,
            v: excursion.resting_corner.v - MIN_DISTANCE_PX,
            w: f64::from(self.window.width) + 2.0 * MIN_DISTANCE_PX,
            h: f64::from(self.window.height) + 2.0 * MIN_DISTANCE_PX,
        };
        let from_s = excursion.start_s + excursion.slide_s;
        let frames = (excursion.away_s / self.target.frame_s) as usize;
        (0..=frames).all(|frame| {
            self.target.at(from_s + frame as f64 * self.target.frame_s).intersection(window).is_empty()
        })
    }

    /// Duration of the path so far, seconds.
    pub(super) fn duration_s(&self) -> f64 {
        self.excursions.last().map_or(0.0, Excursion::end_s) + IN_VIEW_S
    }

    /// The window's corner while it follows the target.
    fn following_corner(&self, time_s: f64) -> PixelPoint {
        let centre = self.target.at(time_s).centre();
        let angle = self.phase + std::f64::consts::TAU * time_s / OSCILLATION_PERIOD_S;
        let (w, h) = (f64::from(self.window.width), f64::from(self.window.height));
        let max = self.max_corner();
        PixelPoint {
            u: (centre.u - w * (0.5 + OSCILLATION * angle.sin())).clamp(0.0, max.u),
            v: (centre.v - h * (0.5 + OSCILLATION * (1.3 * angle).cos())).clamp(0.0, max.v),
        }
    }

    /// The corner that is farthest to the lower right.
    fn max_corner(&self) -> PixelPoint {
        PixelPoint {
            u: f64::from(self.picture.width - self.window.width),
            v: f64::from(self.picture.height - self.window.height),
        }
    }

    /// The window's corner at a time, on even pixels, so that chroma samples need no interpolation.
    pub(super) fn corner(&self, time_s: f64) -> (usize, usize) {
        let mut at = self.following_corner(time_s);
        for excursion in &self.excursions {
            let share = excursion.share_aside(time_s);
            at.u += (excursion.resting_corner.u - at.u) * share;
            at.v += (excursion.resting_corner.v - at.v) * share;
        }
        (at.u as usize & !1, at.v as usize & !1)
    }

    /// A box of the clip's picture in the window's coordinates.
    pub(super) fn to_window(&self, bounds: PixelBox, time_s: f64) -> PixelBox {
        let corner = self.corner(time_s);
        PixelBox { u: bounds.u - corner.0 as f64, v: bounds.v - corner.1 as f64, ..bounds }
    }

    /// The share of the target's box in the window, 0 to 1.
    pub(super) fn visible_share(&self, time_s: f64) -> f64 {
        let whole = self.to_window(self.target.at(time_s), time_s);
        whole.clipped(self.window).area() / whole.area()
    }
}
