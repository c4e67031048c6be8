//! Video files and encoded pictures.

use barrelman_video::annexb::{AvcConfiguration, is_bidirectional, kind, nals};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::demux::FileReader;
use barrelman_video::mode::DecodeMode;
use barrelman_video::url::VideoUrl;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use bytes::Bytes;

use crate::memory_file::MemoryFile;

/// Most units that are read of a file.
const UNITS: usize = 64;

/// An MP4 file: any bytes, and the same behind a file type box.
pub fn mp4(bytes: &[u8]) {
    read_file(bytes);
    read_file(&[b"\0\0\0\x10ftypisom\0\0\0\0".as_slice(), bytes].concat());
}

/// A Y4M file: any bytes, and the same behind the format's first word.
pub fn y4m(bytes: &[u8]) {
    read_file(bytes);
    read_file(&[b"YUV4MPEG2 ".as_slice(), bytes].concat());
}

/// Units or an error; raw pictures are converted, too.
fn read_file(bytes: &[u8]) {
    let file = MemoryFile::new(bytes);
    let Ok(mut reader) = FileReader::open(&VideoUrl::file(file.path())) else { return };
    let mut decoder = UnitDecoder::new(DecodeMode::File);
    for _ in 0..UNITS {
        let Ok(Some(unit)) = reader.next_unit() else { break };
        if matches!(unit.codec, UnitCodec::RawYuv420 { .. }) {
            let _ = decoder.decode(&unit, &mut |_| {});
        }
    }
}

/// H.264: the units of Annex B, the configuration of an MP4 file with a sample behind it, and the decoder.
pub fn h264(bytes: &[u8]) {
    for nal in nals(bytes) {
        assert!(nal.len() <= bytes.len());
        let _ = (kind(nal), is_bidirectional(nal));
    }
    if let Some(configuration) = AvcConfiguration::parse(bytes)
        && let Ok(unit) = configuration.to_annex_b(bytes)
    {
        assert!(nals(&unit.bytes).count() <= unit.bytes.len());
    }
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    let halves = bytes.split_at(bytes.len() / 2);
    for (index, payload) in [bytes, halves.0, halves.1].into_iter().enumerate() {
        let unit = EncodedUnit {
            epoch: 0,
            index: index as u64,
            capture: Capture { at: Timestamp::from_nanos(index as u64), quality: CaptureQuality::Sender },
            key: true,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: Bytes::copy_from_slice(payload),
        };
        let _ = decoder.decode(&unit, &mut |frame| {
            let size = frame.picture.size();
            assert!(size.width > 0 && size.height > 0);
        });
    }
}
