//! A view as a short sequence of pictures, with the truth of each.

use std::sync::Arc;

use anyhow::{Context, Result};
use barrelman_sim::render::{ENCODING, Serial};
use barrelman_sim::tick::TICK_S;
use barrelman_vocab::{Picture, PictureSize, PixelBox};

use super::catalogue::views;
use super::scene::{self, END_TICK};
use super::setting::{Setting, WAKE_STEP_TICKS};

/// Ticks from picture to picture: 15 pictures a second.
const STEP_TICKS: u64 = 8;

/// A picture of a sequence.
pub(crate) struct SequenceFrame {
    /// Time since the start of the sequence, seconds.
    pub(crate) time_s: f64,
    pub(crate) picture: Arc<Picture>,
    /// Smallest box around the visible part of the target; `None` where none of it is visible.
    pub(crate) bounds: Option<PixelBox>,
}

/// Renders the last seconds of the view of this name, at 15 pictures a second.
///
/// # Errors
/// If there is no view of this name.
pub(crate) fn render_sequence(name: &str, size: PictureSize, seconds: f64) -> Result<Vec<SequenceFrame>> {
    let views = views();
    let view = views.iter().find(|view| view.name == name).with_context(|| format!("no view {name}"))?;
    let Setting { sea, mut renderer } = Setting::new(view, size)?;
    let frames = (seconds / (STEP_TICKS as f64 * TICK_S)).round() as u64;
    let first = END_TICK - (frames.max(1) - 1) * STEP_TICKS;
    for tick in (0..first).step_by(WAKE_STEP_TICKS) {
        renderer.advance_wake(&scene::snapshot(view, &sea, tick));
    }
    let mut sequence = Vec::new();
    for tick in (first..=END_TICK).step_by(WAKE_STEP_TICKS) {
        let snapshot = scene::snapshot(view, &sea, tick);
        renderer.advance_wake(&snapshot);
        if !(tick - first).is_multiple_of(STEP_TICKS) {
            continue;
        }
        let mut picture = Picture::black(size, ENCODING);
        let bounds = renderer.render(&snapshot, &mut picture, &Serial).bounds;
        let time_s = (tick - first) as f64 * TICK_S;
        sequence.push(SequenceFrame { time_s, picture: Arc::new(picture), bounds });
    }
    Ok(sequence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_shows_the_moving_boat_at_fifteen_pictures_a_second() {
        let sequence = render_sequence("1_lake_10m_p30", PictureSize::new(160, 90), 0.4).unwrap();
        let times: Vec<f64> = sequence.iter().map(|frame| (frame.time_s * 15.0).round()).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!(sequence.iter().all(|frame| frame.bounds.is_some()));
        assert_ne!(sequence[0].bounds, sequence[5].bounds);
    }

    #[test]
    fn an_unknown_view_is_an_error() {
        assert!(render_sequence("none", PictureSize::new(160, 90), 0.1).is_err());
    }
}
