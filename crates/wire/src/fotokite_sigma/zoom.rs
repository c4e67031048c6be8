//! The zoom: a Sigma takes a level and goes there by itself. A speed is carried out as small steps of the
//! level, of which the last one ends the motion.

use core::time::Duration;

use barrelman_vocab::{Timestamp, ZoomAbility, ZoomRate};

use super::json::VideoStream;

/// Interval between two steps.
pub const STEP: Duration = Duration::from_millis(150);

/// The level, and when it is changed next.
#[derive(Debug, Clone)]
pub struct ZoomSteps {
    /// The rate at the largest speed.
    full: ZoomRate,
    /// Smallest and largest level of the stream; `None`: it does not zoom.
    range: Option<(f64, f64)>,
    /// The level that was told, or commanded since; `None`: not known.
    level: Option<f64>,
    stepped: Option<Timestamp>,
}

impl ZoomSteps {
    /// Steps of a zoom with this rate at its largest speed.
    pub const fn new(full: ZoomRate) -> Self {
        Self { full, range: None, level: None, stepped: None }
    }

    /// Takes what the vehicle states of the stream.
    pub fn set_stream(&mut self, stream: Option<&VideoStream>) {
        let range = stream.and_then(|stream| stream.zoom_min.zip(stream.zoom_max));
        self.range = range.filter(|(least, most)| 0.0 < *least && least < most && most.is_finite());
    }

    /// Whether the stream that was stated zooms.
    pub const fn ability(&self) -> ZoomAbility {
        ZoomAbility::told(self.range.is_some())
    }

    /// The vehicle tells the level. What was commanded a moment ago is newer.
    pub fn on_level(&mut self, level: f64, now: Timestamp) {
        let is_stepping = self.stepped.is_some_and(|at| now.since(at) < 4 * STEP);
        if level.is_finite() && level > 0.0 && !(is_stepping && self.level.is_some()) {
            self.level = Some(level);
        }
    }

    /// A step was answered, or not. The level is not known after one that was refused. The vehicle begins a
    /// step that was held up when it answers: the next step waits from then on, as the motion would otherwise
    /// go on after the last one.
    pub fn on_answer(&mut self, is_accepted: bool, now: Timestamp) {
        if !is_accepted {
            self.level = None;
        } else if self.stepped.is_some_and(|at| now.since(at) > STEP) {
            self.stepped = Some(now);
        }
    }

    /// The next level, if one is due at this speed, -1 to 1.
    pub fn due(&mut self, speed: f64, now: Timestamp) -> Option<f64> {
        let (least, most) = self.range.filter(|_| speed != 0.0)?;
        if self.stepped.is_some_and(|at| now.since(at) < STEP) {
            return None;
        }
        let before = self.level?;
        let exponent = speed.clamp(-1.0, 1.0) * self.full.per_second() * STEP.as_secs_f64();
        let level = (before * libm::exp(exponent)).clamp(least, most);
        if level.is_nan() || level.to_bits() == before.to_bits() {
            return None;
        }
        (self.level, self.stepped) = (Some(level), Some(now));
        Some(level)
    }

    /// When the next step is due at this speed.
    pub fn wake_at(&self, speed: f64) -> Option<Timestamp> {
        (speed != 0.0 && self.range.is_some())
            .then(|| self.stepped.map_or(Timestamp::ZERO, |at| at.plus(STEP)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos((10_000 + ms) * 1_000_000)
    }

    fn steps() -> ZoomSteps {
        let mut steps = ZoomSteps::new(ZoomRate::from_per_second(0.3));
        let stream = r#"{"stream_id":"zoom","zoom_min":1.0,"zoom_max":32.0}"#;
        steps.set_stream(Some(&serde_json::from_str(stream).unwrap()));
        steps
    }

    /// The levels that are sent at a speed within some time.
    fn sent(steps: &mut ZoomSteps, speed: f64, (from, to): (u64, u64)) -> Vec<f64> {
        (from..to).step_by(10).filter_map(|ms| steps.due(speed, at(ms))).collect()
    }

    #[test]
    fn a_speed_becomes_small_steps_within_the_range() {
        let mut steps = steps();
        assert_eq!(sent(&mut steps, 1.0, (0, 1000)), [0.0; 0], "the level is not known");
        steps.on_level(4.0, at(1000));
        let levels = sent(&mut steps, 1.0, (1000, 2000));
        assert_eq!(levels.len(), 7);
        assert!((levels[6] / 4.0 - libm::exp(7.0 * 0.3 * 0.15)).abs() < 1e-9, "{levels:?}");
        assert_eq!(sent(&mut steps, 0.0, (2000, 3000)), [0.0; 0]);
        let wider = sent(&mut steps, -0.5, (3000, 60_000));
        assert_eq!(*wider.last().unwrap(), 1.0);
        assert!(wider.len() < 100, "at the end there is nothing more to send: {}", wider.len());
    }

    #[test]
    fn what_is_told_counts_at_rest_and_after_a_refusal() {
        let mut steps = steps();
        steps.on_level(4.0, at(0));
        let first = steps.due(1.0, at(0)).unwrap();
        steps.on_level(4.0, at(100));
        assert!(steps.due(1.0, at(150)).unwrap() > first, "the report is older than the step");
        steps.on_answer(false, at(290));
        assert_eq!(steps.due(1.0, at(300)), None);
        steps.on_level(9.0, at(400));
        assert!(steps.due(1.0, at(450)).unwrap() > 9.0);
    }

    #[test]
    fn a_step_that_was_held_up_delays_the_next_one() {
        let mut steps = steps();
        steps.on_level(4.0, at(0));
        assert!(steps.due(1.0, at(0)).is_some());
        steps.on_answer(true, at(20));
        assert!(steps.due(1.0, at(150)).is_some(), "an answer in time changes nothing");
        steps.on_answer(true, at(600));
        assert_eq!(steps.due(1.0, at(740)), None);
        assert!(steps.due(1.0, at(750)).is_some());
    }

    #[test]
    fn a_stream_without_a_usable_range_does_not_zoom() {
        for stream in [r#"{"stream_id":"thermal"}"#, r#"{"stream_id":"zoom","zoom_min":0.0,"zoom_max":9.0}"#]
        {
            let mut steps = steps();
            steps.set_stream(Some(&serde_json::from_str(stream).unwrap()));
            steps.on_level(2.0, at(0));
            assert_eq!((steps.due(1.0, at(0)), steps.wake_at(1.0)), (None, None), "{stream}");
        }
    }
}
