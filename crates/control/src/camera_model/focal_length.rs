//! The focal length of a camera with zoom: what was reported, and how the commands have changed it since.
//!
//! `f(t) = base(t) exp(z(t))`: z integrates the commands to zoom from their effect on, and base is what
//! reports have made of it. While the camera zooms by command, a report corrects z a little, as reports come
//! late; at rest a report is taken over, since somebody else has zoomed. Where nothing is reported, the
//! growth of the picture corrects z.

use core::time::Duration;

use barrelman_vocab::profile::AxisDynamics;
use barrelman_vocab::{AngularRate, Timestamp, ZoomDynamics, ZoomRate};

use super::axis::AxisModel;
use super::focal_history::FocalHistory;

/// Smallest relative change of the focal length that counts as a zoom: reports are rounded.
const MIN_FOCAL_CHANGE: f64 = 0.002;
/// Share of the error that one report corrects while the camera zooms by command.
const REPORT_SHARE: f64 = 0.2;
/// The camera rests where it has not zoomed for this time: reports are about half a second late.
const SETTLED: Duration = Duration::from_secs(1);

/// A camera may zoom this many times as fast as its profile says.
const MAX_GROWTH: f64 = 3.0;

/// The zoom of a camera that takes commands and has never reported a field of view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnreportedZoom {
    /// It has not zoomed for a second.
    Resting,
    /// It zooms, or may still do.
    Moving,
}

/// The focal length over time.
#[derive(Debug, Clone)]
pub(super) struct FocalLength {
    base: FocalHistory,
    /// `None`: the camera does not zoom by command.
    zoom: Option<ZoomModel>,
    is_reported: bool,
    /// Of the camera of another video.
    of_other: Option<f64>,
    /// When the pictures became those of another video.
    changed_at: Timestamp,
}

#[derive(Debug, Clone)]
struct ZoomModel {
    /// z, and its rate.
    exponent: AxisModel,
    /// Smallest and largest focal length, as shares of the picture's width.
    range: (f64, f64),
}

impl ZoomModel {
    /// Whether the camera has not zoomed for a while.
    fn is_settled(&self, at_s: f64) -> bool {
        let angle = |at_s: f64| self.exponent.at(at_s).angle;
        angle(at_s).to_bits() == angle(at_s - SETTLED.as_secs_f64()).to_bits()
    }
}

impl FocalLength {
    /// The widest view, at rest.
    pub(super) fn new(widest: f64, zoom: Option<ZoomDynamics>) -> Self {
        let model = |zoom: ZoomDynamics| {
            let dynamics = AxisDynamics {
                start_dead_time: zoom.dead_time,
                stop_dead_time: zoom.dead_time,
                lag: Duration::ZERO,
                min_rate: AngularRate::ZERO,
                gain: 1.0,
            };
            let range = (widest, widest * zoom.ratio);
            let stops = stops_of(range, widest);
            let exponent = AxisModel::new(dynamics, zoom.max_rate.per_second(), 0.0, Some(stops));
            ZoomModel { exponent, range }
        };
        Self {
            base: FocalHistory::new(widest),
            zoom: zoom.map(model),
            is_reported: false,
            of_other: None,
            changed_at: Timestamp::ZERO,
        }
    }

    /// The pictures are those of another video from now on; `Some`: of a camera of its own, with this focal
    /// length. The camera's own is kept meanwhile.
    pub(super) const fn change_video(&mut self, of_other: Option<f64>, at: Timestamp) {
        (self.of_other, self.changed_at) = (of_other, at);
    }

    /// The focal length of another video's camera, if that is the one that is seen through.
    pub(super) const fn of_other(&self) -> Option<f64> {
        self.of_other
    }

    /// Advances to `now` without a new command.
    pub(super) fn advance(&mut self, now: Timestamp) {
        if let Some(zoom) = &mut self.zoom {
            let until_s = now.as_secs_f64() + zoom.exponent.start_s();
            zoom.exponent.advance(until_s);
        }
    }

    /// Puts a rate in force from `now` on.
    pub(super) fn command(&mut self, rate: ZoomRate, now: Timestamp) {
        if let Some(zoom) = &mut self.zoom {
            zoom.exponent.command(rate.per_second(), now.as_secs_f64());
        }
    }

    /// Takes a report of the focal length, a share of the picture's width, at a time.
    pub(super) fn report(&mut self, share: f64, at: Timestamp) {
        self.is_reported = true;
        let known = self.own_at(at);
        if (share - known).abs() <= MIN_FOCAL_CHANGE * known {
            return;
        }
        let Some(zoom) = &mut self.zoom else {
            self.base.push(share, at);
            return;
        };
        let at_s = at.as_secs_f64();
        if zoom.is_settled(at_s) {
            let base = share / libm::exp(zoom.exponent.at(at_s).angle);
            self.base.push(base, at);
            zoom.exponent.set_stops(stops_of(zoom.range, base));
        } else {
            zoom.exponent.shift(REPORT_SHARE * libm::log(share / known));
        }
    }

    /// How the camera zooms at a time, where nothing is reported: the growth of the picture then tells its
    /// focal length.
    pub(super) fn unreported_zoom(&self, at: Timestamp) -> Option<UnreportedZoom> {
        let zoom = self.zoom.as_ref().filter(|_| !self.is_reported && self.of_other.is_none())?;
        Some(match zoom.is_settled(at.as_secs_f64()) {
            true => UnreportedZoom::Resting,
            false => UnreportedZoom::Moving,
        })
    }

    /// Takes the measured growth of the picture between two times, the logarithm of its scale. A growth that
    /// no zoom makes is ignored.
    pub(super) fn grow(&mut self, growth: f64, from: Timestamp, to: Timestamp) {
        let Some(zoom) = &mut self.zoom else { return };
        let (from_s, to_s) = (from.as_secs_f64(), to.as_secs_f64());
        let most = MAX_GROWTH * zoom.exponent.limit() * (to_s - from_s);
        if growth.abs() <= most {
            let expected = zoom.exponent.at(to_s).angle - zoom.exponent.at(from_s).angle;
            zoom.exponent.shift(growth - expected);
        }
    }

    /// The focal length at a time, a share of the picture's width.
    pub(super) fn at(&self, at: Timestamp) -> f64 {
        self.of_other.unwrap_or_else(|| self.own_at(at))
    }

    fn own_at(&self, at: Timestamp) -> f64 {
        let base = self.base.at(at);
        self.zoom.as_ref().map_or(base, |zoom| base * libm::exp(zoom.exponent.at(at.as_secs_f64()).angle))
    }

    /// Whether something else than a command has changed it between two times.
    pub(super) fn is_changed_by_another(&self, from: Timestamp, to: Timestamp) -> bool {
        let has_changed_video = from < self.changed_at && self.changed_at <= to;
        has_changed_video
            || (self.of_other.is_none() && self.base.at(from).to_bits() != self.base.at(to).to_bits())
    }
}

/// The least and the largest exponent within a range of focal lengths. A focal length that was reported
/// outside of the range belongs to it.
fn stops_of((least, largest): (f64, f64), base: f64) -> (f64, f64) {
    (libm::log(least / base).min(0.0), libm::log(largest / base).max(0.0))
}
