//! One picture of a recording: what the list of recordings shows.

use std::io::{Read, Seek};
use std::time::Duration;

use anyhow::Result;
use barrelman_trial::records::{Entry, IndexedRecording};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::jpeg;
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::{VideoFrame, VideoNumber};

use super::part::{first_step, key_unit};

/// Units after which a decoder without a picture is given up.
const MAX_UNITS: usize = 30;

/// The picture from the middle of a recording, as JPEG in its own size; `None`: there is no video, or this
/// program does not decode it.
///
/// # Errors
/// If the recording cannot be read.
pub(super) fn thumbnail_of<R: Read + Seek>(recording: &mut IndexedRecording<R>) -> Result<Option<Vec<u8>>> {
    let Some(first) = first_step(recording)? else { return Ok(None) };
    let half = recording.sortie()?.map_or(0.0, |sortie| sortie.length_s / 2.0);
    let middle = first.plus(Duration::try_from_secs_f64(half).unwrap_or_default());
    let Some(key) = key_unit(recording, VideoNumber::First, middle)? else { return Ok(None) };
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    let (mut found, mut units) = (None::<VideoFrame>, 0);
    recording.entries_from(key, |entry| {
        if let Entry::Unit(VideoNumber::First, unit) = entry {
            units += 1;
            // A damaged unit gives no picture: a later one may.
            let _ = decoder.decode(&unit, &mut |frame| found = Some(frame));
        }
        found.is_none() && units < MAX_UNITS
    })?;
    Ok(found.and_then(|frame| jpeg::encode(&frame.picture).ok()))
}
