//! Time to decode and to encode a picture, on one thread: `cargo bench -p barrelman-video`.
//!
//! The clip is generated: 1280x720, a moving texture, baseline profile, 4 Mbit/s. With nasm on the PATH at
//! build time, the cost is half.

use barrelman_video::decoder::UnitDecoder;
use barrelman_video::encoder::{EncoderSettings, H264Encoder};
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, Picture};
use divan::counter::ItemsCount;

const SIZE: PictureSize = PictureSize::new(1280, 720);
const PICTURES: u64 = 60;
const SETTINGS: EncoderSettings = EncoderSettings { fps: 30.0, bits_per_second: 4_000_000 };

fn main() {
    divan::main();
}

fn at(index: u64) -> Timestamp {
    Timestamp::from_nanos(index * 33_333_333)
}

fn pictures() -> Vec<Picture> {
    let picture = |index: u64| {
        let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
        let width = SIZE.width as usize;
        let mut noise = index + 1;
        for (place, sample) in picture.planes_mut()[0].iter_mut().enumerate() {
            let (row, column) = (place / width, place % width + 4 * index as usize);
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *sample = (60 + ((column / 7) ^ (row / 5)) % 90 + (noise >> 62) as usize) as u8;
        }
        picture
    };
    (0..PICTURES).map(picture).collect()
}

fn units() -> Vec<EncodedUnit> {
    let mut encoder = H264Encoder::new(SETTINGS);
    let unit = |(index, picture): (u64, &Picture)| {
        let encoded = encoder.encode(picture, at(index)).expect("1280x720 can be encoded");
        EncodedUnit {
            epoch: 0,
            index,
            capture: Capture { at: at(index), quality: CaptureQuality::Sender },
            key: encoded.key,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: encoded.bytes.into(),
        }
    };
    (0..).zip(&pictures()).map(unit).collect()
}

#[divan::bench(args = [Rotation::None, Rotation::Clockwise90], sample_count = 10)]
fn decode_60_pictures_720p(bencher: divan::Bencher<'_, '_>, rotation: Rotation) {
    let mut units = units();
    units.iter_mut().for_each(|unit| unit.rotation = rotation);
    bencher.counter(ItemsCount::new(PICTURES)).bench_local(|| {
        let mut decoder = UnitDecoder::new(DecodeMode::Live);
        let mut frames = 0;
        for unit in &units {
            decoder.decode(unit, &mut |_| frames += 1).expect("the clip is intact");
        }
        assert_eq!(frames, PICTURES);
    });
}

#[divan::bench(sample_count = 10)]
fn encode_60_pictures_720p(bencher: divan::Bencher<'_, '_>) {
    let pictures = pictures();
    bencher.counter(ItemsCount::new(PICTURES)).bench_local(|| {
        let mut encoder = H264Encoder::new(SETTINGS);
        let sizes = (0..).zip(&pictures).map(|(index, picture)| {
            encoder.encode(picture, at(index)).expect("1280x720 can be encoded").bytes.len()
        });
        sizes.sum::<usize>()
    });
}
