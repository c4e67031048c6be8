//! What the states of a camera tell of its motion.

use core::time::Duration;

use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Angle, AngularRate, Timestamp, wrapped};

use super::answers::{PanTilt, Status};
use crate::session::RestEvidence;

/// A camera that turns slower than this rests: positions are rounded, to a tenth of a degree by some cameras.
pub const AT_REST: AngularRate = AngularRate::from_radians_per_second(0.02);
/// Least time between two states from which a rate is computed: positions are rounded.
const LEAST_INTERVAL: Duration = Duration::from_millis(80);
/// Older states tell nothing.
const RECENT: Duration = Duration::from_millis(600);
/// What a position of 1 stands for where a camera states no unit, radians: half a turn, and a quarter.
const FULL_PAN: f64 = core::f64::consts::PI;
const FULL_TILT: f64 = core::f64::consts::FRAC_PI_2;

/// What two states show.
#[derive(Debug, Clone, Copy)]
struct Shown {
    first: Timestamp,
    second: Timestamp,
    evidence: RestEvidence,
}

/// Where the camera pointed, and what it says of its motion.
#[derive(Debug, Clone, Copy, Default)]
pub struct MotionWatch {
    last: Option<(Timestamp, f64, f64)>,
    shown: Option<Shown>,
    /// Whether the camera has ever said that it moves: one that never does tells nothing by resting.
    has_said_moving: bool,
}

impl MotionWatch {
    /// Takes a state.
    pub fn on_status(&mut self, status: &Status, now: Timestamp) {
        let position = status.position.as_ref().and_then(|position| position.pan_tilt.as_ref());
        match position.and_then(radians) {
            Some((pan, tilt)) => self.on_position(pan, tilt, now),
            None => self.on_words(status, now),
        }
    }

    fn on_position(&mut self, pan: f64, tilt: f64, now: Timestamp) {
        if let Some((before, pan_before, tilt_before)) = self.last {
            let interval = now.since(before);
            if interval < LEAST_INTERVAL {
                return;
            }
            let turned = wrapped(pan - pan_before).abs().max((tilt - tilt_before).abs());
            let rate = AngularRate::from_radians_per_second(turned / interval.as_secs_f64());
            let evidence = if rate < AT_REST { RestEvidence::AtRest } else { RestEvidence::Moving { rate } };
            self.shown = Some(Shown { first: before, second: now, evidence });
        }
        self.last = Some((now, pan, tilt));
    }

    fn on_words(&mut self, status: &Status, now: Timestamp) {
        let evidence = match status.moving.as_ref().and_then(|moving| moving.pan_tilt.as_deref()) {
            Some("MOVING") => {
                self.has_said_moving = true;
                RestEvidence::Moving { rate: AT_REST }
            }
            Some("IDLE") if self.has_said_moving => RestEvidence::AtRest,
            _ => return,
        };
        self.shown = Some(Shown { first: now, second: now, evidence });
    }

    /// What the states from after `since` show of the camera's motion.
    pub fn since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        let recent = |shown: &Shown| shown.first >= since && now.since(shown.second) <= RECENT;
        self.shown.filter(recent).map_or(RestEvidence::NoTelemetry, |shown| shown.evidence)
    }
}

/// Where the camera points, where it says so in degrees.
pub fn reports(status: &Status) -> [Option<Report>; 2] {
    let position = status.position.as_ref().and_then(|position| position.pan_tilt.as_ref());
    let Some(PanTilt { pan, tilt, .. }) = position.filter(|position| position.is_degrees()) else {
        return [None, None];
    };
    let angle = |degrees: f64, report: fn(Angle) -> Report| {
        (-360.0..=360.0).contains(&degrees).then(|| report(Angle::from_degrees(degrees)))
    };
    [angle(*pan, Report::CameraPan), angle(*tilt, Report::CameraTilt)]
}

/// A position in radians; `None`: it is no position.
fn radians(position: &PanTilt) -> Option<(f64, f64)> {
    let unit = if position.is_degrees() {
        (core::f64::consts::PI / 180.0, core::f64::consts::PI / 180.0)
    } else {
        (FULL_PAN, FULL_TILT)
    };
    let (pan, tilt) = (position.pan * unit.0, position.tilt * unit.1);
    (pan.is_finite() && tilt.is_finite()).then_some((pan, tilt))
}
