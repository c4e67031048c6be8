//! Draws the pilot's state on frames, and encodes them.

use std::time::Duration;

use barrelman_overlay::{Overlay, Scene};
use barrelman_video::VideoError;
use barrelman_video::encoder::{EncodedPicture, EncoderSettings, H264Encoder};
use barrelman_video::media::share::Demand;
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize, Timestamp};

use super::slot::Shown;

/// Frames per second that the encoder expects.
const NOMINAL_FPS: f64 = 30.0;
/// Shortest time between key frames: readers that come and go cannot make every frame one.
const MIN_KEY_INTERVAL: Duration = Duration::from_millis(200);

/// Draws and encodes. Reuses its buffers from one frame to the next.
pub(super) struct Annotator {
    overlay: Overlay,
    drawn: Picture,
    encoder: Option<(PictureSize, H264Encoder)>,
    /// Whether a reader waits for a key frame.
    needs_key: bool,
    last_key: Option<Timestamp>,
    last: Timestamp,
}

impl Annotator {
    pub(super) fn new() -> Self {
        Self {
            overlay: Overlay::new(),
            drawn: Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG),
            encoder: None,
            needs_key: false,
            last_key: None,
            last: Timestamp::ZERO,
        }
    }

    /// Takes what the readers need.
    pub(super) fn on_demand(&mut self, demand: Demand) {
        self.needs_key |= demand == Demand::KeyFrame;
    }

    /// Draws and encodes a frame. Where the time begins anew, as in a new drive, the video begins with a key
    /// frame.
    ///
    /// # Errors
    /// A size that H.264 does not allow.
    pub(super) fn encode(
        &mut self,
        shown: &Shown,
        time_of_day: Option<&str>,
    ) -> Result<EncodedPicture, VideoError> {
        let (frame, at) = (&shown.frame, shown.frame.capture.at);
        let picture = match Scene::from_outcome(&shown.outcome) {
            Some(scene) => {
                let scene = Scene { rates: Some(shown.rates), time_of_day, ..scene };
                self.overlay.draw(frame, &scene, &mut self.drawn);
                &self.drawn
            }
            None => &*frame.picture,
        };
        let size = picture.size();
        let new = || (size, H264Encoder::new(EncoderSettings::for_pictures(size, NOMINAL_FPS)));
        let begins_anew = at < std::mem::replace(&mut self.last, at);
        let kept = self.encoder.take().filter(|(before, _)| *before == size && !begins_anew);
        let (_, encoder) = self.encoder.insert(kept.unwrap_or_else(new));
        let is_due = self.last_key.is_none_or(|last| at < last || at.since(last) >= MIN_KEY_INTERVAL);
        let encoded = if self.needs_key && is_due {
            encoder.encode_key_frame(picture, at)?
        } else {
            encoder.encode(picture, at)?
        };
        if encoded.key {
            (self.needs_key, self.last_key) = (false, Some(at));
        }
        Ok(encoded)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use barrelman_pilot::{CommandPath, Input, Pilot, PilotSettings};
    use barrelman_vocab::video::{Capture, CaptureQuality};
    use barrelman_vocab::{VehicleRates, VideoFrame};

    use super::*;
    use crate::config::Configuration;

    fn shown(ms: u64, size: PictureSize) -> Shown {
        let configuration = Configuration::resolve(&crate::config::ConfigFile::default()).unwrap();
        let settings = PilotSettings { profile: configuration.profile, law: configuration.law.settings() };
        let mut pilot =
            Pilot::new(settings, configuration.tracker.build().unwrap()).commanding(CommandPath::DryRun);
        let at = Timestamp::ZERO.plus(Duration::from_millis(ms));
        let picture = Arc::new(Picture::black(size, ColourEncoding::JPEG));
        let capture = Capture { at, quality: CaptureQuality::Arrival };
        let frame = VideoFrame { sequence: 0, capture, picture };
        let outcome = pilot.step(Input::Frame(&frame), at);
        Shown { frame, outcome, rates: VehicleRates::REST }
    }

    const SMALL: PictureSize = PictureSize::new(320, 180);

    #[test]
    fn a_reader_gets_a_key_frame_but_readers_cannot_make_every_frame_one() {
        let mut annotator = Annotator::new();
        let mut keys = Vec::new();
        for ms in (0..600).step_by(40) {
            annotator.on_demand(Demand::KeyFrame);
            keys.extend(annotator.encode(&shown(ms, SMALL), None).unwrap().key.then_some(ms));
        }
        assert_eq!(keys, [0, 200, 400]);
        // The first frames of another drive.
        assert!(annotator.encode(&shown(40, SMALL), None).unwrap().key);
        assert!(!annotator.encode(&shown(80, SMALL), None).unwrap().key);
    }
}
