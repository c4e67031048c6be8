//! Localisations made from the truth with noise, for trials without pixels.

use barrelman_vocab::{ImagePoint, Localisation, PixelBox};

use crate::random::{CounterRng, OrnsteinUhlenbeckProcess, Stream};
use crate::scenario::{BeyondBorder, CameraSetup, SensorModel};
use crate::world::Truth;

/// Measures the target's place in the picture.
#[derive(Debug, Clone)]
pub struct LocalisationSensor {
    sensing: SensorModel,
    camera: CameraSetup,
    across: OrnsteinUhlenbeckProcess,
    upward: OrnsteinUhlenbeckProcess,
    tick: u64,
}

impl LocalisationSensor {
    /// The sensor of a trial.
    pub fn new(sensing: SensorModel, camera: CameraSetup, seed: u64) -> Self {
        let noise = |stream| OrnsteinUhlenbeckProcess::new(sensing.noise, CounterRng::new(seed, stream));
        Self { sensing, camera, across: noise(Stream::Sensor), upward: noise(Stream::SensorUpward), tick: 0 }
    }

    /// Measures a truth, which must not be older than the one before. `None` where the target is not visible.
    pub fn measure(&mut self, truth: &Truth) -> Option<Localisation> {
        while self.tick < truth.tick {
            self.across.advance(self.tick);
            self.upward.advance(self.tick);
            self.tick += 1;
        }
        let measured = |true_px: f64, noise: OrnsteinUhlenbeckProcess| {
            let noisy = true_px + noise.value();
            if self.sensing.is_rounded { libm::rint(noisy) } else { noisy }
        };
        let (x, y) = (measured(truth.image.x, self.across), measured(truth.image.y, self.upward));
        let (x, y) = match self.sensing.beyond_border {
            BeyondBorder::Clamped { x_px, y_px } => (x.clamp(-x_px, x_px), y.clamp(-y_px, y_px)),
            BeyondBorder::Absent if truth.in_picture => (x, y),
            BeyondBorder::Absent => return None,
        };
        let picture = self.camera.frame;
        let centre = ImagePoint { x, y }.in_pixels(picture);
        let (length, breadth) = self.sensing.target_size_m;
        let px_per_m = self.camera.optics_at(truth.tick).focal_px / truth.range_m;
        let (w, h) = (length * px_per_m, breadth * px_per_m);
        let bounds = PixelBox { u: centre.u - 0.5 * w, v: centre.v - 0.5 * h, w, h };
        Some(Localisation {
            captured: truth.at,
            picture,
            centre,
            bounds: bounds.clipped(picture),
            shape: None,
            heading: None,
            confidence: 1.0,
        })
    }
}
