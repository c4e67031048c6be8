//! The work of the thread `render`: pictures of moments of the world, as encoded units.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use barrelman_experiments::render_threads::RenderThreads;
use barrelman_sim::World;
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::video_link::Delivery;
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{CapturedFrame, FrameSource as _, RenderedCamera};
use barrelman_video::VideoError;
use barrelman_video::encoder::{EncoderSettings, H264Encoder};
use barrelman_vocab::unit::{Rotation, UnitCodec, raw_payload};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{EncodedUnit, Timestamp};
use bytes::Bytes;

use super::delivery::SourceEvent;
use super::moments::Moments;

/// Settings of the rendering.
pub(super) struct RenderingSettings<'a> {
    /// The world at its start.
    pub(super) first: World,
    pub(super) camera: CameraSetup,
    pub(super) seed: u64,
    /// The program's time of the world's start.
    pub(super) start: Timestamp,
    /// The epoch of the units: the number of the world, from 0.
    pub(super) epoch: u32,
    /// Whether pictures travel as H.264.
    pub(super) encoded: bool,
    pub(super) threads: &'a RenderThreads,
}

/// Renders and encodes pictures.
pub(super) struct Rendering<'a> {
    camera: RenderedCamera<'a>,
    start: Timestamp,
    epoch: u32,
    encoder: Option<H264Encoder>,
    /// The last picture, for a moment at which the video is frozen.
    last: Option<CapturedFrame>,
    index: u64,
}

impl<'a> Rendering<'a> {
    pub(super) fn new(settings: RenderingSettings<'a>) -> Self {
        let RenderingSettings { first, camera, seed, start, epoch, encoded, threads } = settings;
        let fps = f64::from(camera.pictures_per_second);
        let encoder_settings = EncoderSettings::for_pictures(camera.frame, fps);
        let simd = Simd::at_most(SimdLevel::Avx512);
        Self {
            camera: RenderedCamera::new(&first, camera, seed, simd, threads),
            start,
            epoch,
            encoder: encoded.then(|| H264Encoder::new(encoder_settings)),
            last: None,
            index: 0,
        }
    }

    /// Renders the newest moment repeatedly, until no further moment follows.
    pub(super) fn run(mut self, moments: &Moments, units: &SyncSender<SourceEvent>) {
        while let Some(moment) = moments.newest.wait() {
            let (Delivery::Arrives { at } | Delivery::Frozen { at }) = moment.delivery else { continue };
            let is_frozen = matches!(moment.delivery, Delivery::Frozen { .. });
            let view = match self.last.take() {
                Some(last) if is_frozen => last,
                _ => self.camera.capture(&moment.world),
            };
            let unit = self.unit(&view, self.on_the_clock(moment.world.tick()));
            let target = view.target.bounds;
            self.last = Some(view);
            let delivery = match unit {
                Ok(unit) => SourceEvent::Picture { at: self.on_the_clock(at), unit, target },
                Err(error) => SourceEvent::Failed(error),
            };
            if units.send(delivery).is_err() {
                return;
            }
        }
        let left_out = moments.newest.replaced();
        if left_out > 0 {
            tracing::warn!("{left_out} pictures were not rendered in time: use smaller ones (?size=WxH)");
        }
        if !moments.has_failed() {
            let _ = units.send(SourceEvent::End);
        }
    }

    /// The program's time of a tick of the world.
    fn on_the_clock(&self, tick: u64) -> Timestamp {
        self.start.plus(World::time_of(tick).since(Timestamp::ZERO))
    }

    fn unit(&mut self, view: &CapturedFrame, taken_at: Timestamp) -> Result<EncodedUnit, VideoError> {
        let picture = &view.frame.picture;
        let (key, codec, payload) = match &mut self.encoder {
            Some(encoder) => {
                let encoded = encoder.encode(picture, taken_at)?;
                (encoded.key, UnitCodec::H264AnnexB, Bytes::from(encoded.bytes))
            }
            None => {
                let codec = UnitCodec::RawYuv420 { size: picture.size(), colour: picture.colour() };
                (true, codec, raw_payload(Arc::clone(picture)))
            }
        };
        let index = self.index;
        self.index += 1;
        let capture = Capture { at: taken_at, quality: CaptureQuality::Sensor };
        let (shown, rotation) = (true, Rotation::None);
        Ok(EncodedUnit { epoch: self.epoch, index, capture, key, shown, rotation, codec, payload })
    }
}
