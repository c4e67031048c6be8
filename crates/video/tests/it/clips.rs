//! Helpers of several tests: reads and decodes the clips of `fixtures/video`.

use std::path::{Path, PathBuf};

use barrelman_video::decoder::UnitDecoder;
use barrelman_video::demux::FileReader;
use barrelman_video::mode::DecodeMode;
use barrelman_video::{DecodeError, VideoError, VideoFrames, VideoUrl};
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

/// The path of a fixture.
pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/video").join(name)
}

/// All frames of a file, and the error at its end, if any.
pub(crate) fn read(path: PathBuf) -> (Vec<VideoFrame>, Option<VideoError>) {
    let mut frames = match VideoFrames::open(&VideoUrl::file(path)) {
        Ok(frames) => frames,
        Err(error) => return (Vec::new(), Some(error)),
    };
    let mut all = Vec::new();
    loop {
        match frames.next_frame() {
            Ok(Some(frame)) => all.push(frame),
            Ok(None) => return (all, None),
            Err(error) => return (all, Some(error)),
        }
    }
}

/// The units of a file.
pub(crate) fn units(file: &str) -> Vec<EncodedUnit> {
    units_of(&fixture(file))
}

pub(crate) fn units_of(path: &Path) -> Vec<EncodedUnit> {
    let mut reader = FileReader::open(&VideoUrl::file(path)).unwrap();
    std::iter::from_fn(|| reader.next_unit().unwrap()).collect()
}

pub(crate) fn decode(units: &[EncodedUnit], mode: DecodeMode) -> (Vec<VideoFrame>, Vec<DecodeError>) {
    let (mut frames, mut errors) = (Vec::new(), Vec::new());
    let mut decoder = UnitDecoder::new(mode);
    for unit in units {
        errors.extend(decoder.decode(unit, &mut |frame| frames.push(frame)).err());
    }
    decoder.finish(&mut |frame| frames.push(frame));
    (frames, errors)
}

/// The path of a file that a test may write.
pub(crate) fn output(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Reports a test as skipped because a program is not installed. In CI, where all programs must be installed,
/// it fails.
pub(crate) fn skip(reason: &str) {
    assert!(std::env::var_os("CI").is_none(), "{reason}");
    println!("skipped: {reason}");
}
