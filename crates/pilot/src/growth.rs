//! How much of the picture's growth is that of the zoom, for a camera that does not report its field of view.
//!
//! Waves that come nearer let the picture of the water grow, too, at the same rate at each focal length. What
//! grows while the zoom rests is therefore averaged, and subtracted while it moves.

use barrelman_control::camera_model::UnreportedZoom;
use barrelman_vision::PictureGrowth;
use barrelman_vocab::{Timestamp, VideoFrame};

/// Time constant of the average at rest, seconds.
const MEMORY_S: f64 = 5.0;
/// A longer interval between two frames is a gap, in which anything may have changed.
const MAX_INTERVAL_S: f64 = 0.5;

/// The growth of the picture by the zoom between two times of capture: the logarithm of its scale.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Growth {
    pub(crate) growth: f64,
    pub(crate) from: Timestamp,
    pub(crate) to: Timestamp,
}

/// Measures the growth by the zoom.
#[derive(Debug, Default)]
pub(crate) struct ZoomGrowth {
    pictures: PictureGrowth,
    last: Option<Timestamp>,
    /// Mean rate of the growth while the zoom rests, per second, and how long it was measured, seconds, at
    /// most [`MEMORY_S`].
    at_rest: (f64, f64),
}

impl ZoomGrowth {
    /// The growth by the zoom since the last video frame; `None`: the zoom rests, or nothing was measured.
    pub(crate) fn by_zoom(&mut self, frame: &VideoFrame, zoom: UnreportedZoom) -> Option<Growth> {
        let to = frame.capture.at;
        let growth = self.pictures.measure(&frame.picture);
        let from = self.last.replace(to).filter(|from| *from < to)?;
        let interval_s = to.since(from).as_secs_f64();
        let growth = growth.filter(|_| interval_s <= MAX_INTERVAL_S)?;
        let (mean, measured_s) = &mut self.at_rest;
        match zoom {
            UnreportedZoom::Moving => Some(Growth { growth: growth - interval_s * *mean, from, to }),
            UnreportedZoom::Resting => {
                *measured_s = (*measured_s + interval_s).min(MEMORY_S);
                *mean += interval_s / *measured_s * (growth / interval_s - *mean);
                None
            }
        }
    }
}
