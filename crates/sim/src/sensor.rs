//! Localisations made from the truth with noise, for trials without pixels.

use core::f64::consts::TAU;

use barrelman_vocab::{Angle, ImagePoint, Localisation, PixelBox};

use crate::optics::Optics;
use crate::pose::WorldPoint;
use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::scenario::{BeyondBorder, CameraSetup, SensorModel};
use crate::world::Truth;

/// Time constant of the noise of the heading, seconds.
const HEADING_NOISE_TIME_S: f64 = 0.5;

/// Measures the target's place in the picture.
#[derive(Debug, Clone)]
pub struct LocalisationSensor {
    sensing: SensorModel,
    camera: CameraSetup,
    across: OrnsteinUhlenbeckProcess,
    upward: OrnsteinUhlenbeckProcess,
    heading: Option<OrnsteinUhlenbeckProcess>,
    tick: u64,
}

impl LocalisationSensor {
    /// The sensor of a trial.
    pub fn new(sensing: SensorModel, camera: CameraSetup, seed: u64) -> Self {
        let noise = |stream| OrnsteinUhlenbeckProcess::new(sensing.noise, CounterRng::new(seed, stream));
        let heading = sensing.heading_std_dev.map(|std_dev| {
            let noise =
                OrnsteinUhlenbeck { std_dev: std_dev.radians(), time_constant_s: HEADING_NOISE_TIME_S };
            OrnsteinUhlenbeckProcess::new(noise, CounterRng::new(seed, Stream::SensorHeading))
        });
        let (across, upward) = (noise(Stream::Sensor), noise(Stream::SensorUpward));
        Self { sensing, camera, across, upward, heading, tick: 0 }
    }

    /// Measures a truth, which must not be older than the one before. `None` where the target is not visible.
    pub fn measure(&mut self, truth: &Truth) -> Option<Localisation> {
        while self.tick < truth.tick {
            self.across.advance(self.tick);
            self.upward.advance(self.tick);
            if let Some(heading) = &mut self.heading {
                heading.advance(self.tick);
            }
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
        let px_per_m = truth.focal_px / truth.range_m;
        let (w, h) = (length * px_per_m, breadth * px_per_m);
        let bounds = PixelBox { u: centre.u - 0.5 * w, v: centre.v - 0.5 * h, w, h };
        Some(Localisation {
            captured: truth.at,
            picture,
            centre,
            bounds: bounds.clipped(picture),
            shape: None,
            heading: self.heading(truth),
            confidence: 1.0,
        })
    }

    /// Direction of the bow in the picture with its noise, anticlockwise from image right.
    fn heading(&self, truth: &Truth) -> Option<Angle> {
        let noise = self.heading?;
        let WorldPoint { x, y, z } = truth.target.position;
        let (sin, cos) = libm::sincos(truth.target.heading.radians());
        let optics = Optics { focal_px: truth.focal_px, ..self.camera.optics };
        let seen = |ahead_m: f64| {
            let point = WorldPoint { x: x + ahead_m * cos, y: y + ahead_m * sin, z };
            optics.project(truth.camera.camera_from_world(point))
        };
        let half_m = 0.5 * self.sensing.target_size_m.0;
        let (bow, stern) = (seen(half_m)?, seen(-half_m)?);
        let angle = libm::atan2(stern.v - bow.v, bow.u - stern.u) + noise.value();
        Some(Angle::from_radians(angle - TAU * libm::floor(angle / TAU)))
    }
}
