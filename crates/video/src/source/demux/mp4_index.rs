//! Reads the index of an MP4 file: offset, size, display time and rotation of each picture of the first
//! H.264 track that is not switched off (ISO/IEC 14496-12, 8.5 to 8.8).
//!
//! Times come from `stts` and `ctts` (so the frame rate may vary), shifted by the edit list. Fragments
//! (`moof`) are appended. An edit list may start with a pause and has one piece of the track. More pieces,
//! another speed, and mirrored pictures are unsupported, with an error that names them.

use super::mp4_boxes::{BoxKind, Boxes, Fields};
use super::mp4_samples::{RawSample, append_fragment, table_samples};
use crate::codec::annexb::AvcConfiguration;
use barrelman_vocab::unit::Rotation;

/// One picture in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sample {
    pub(super) offset: u64,
    pub(super) size: u32,
    /// Index into [`Index::configurations`].
    pub(super) configuration: u16,
    pub(super) shown: bool,
    /// Display time, ticks from the start of the video; 0 for pictures that the edit list hides before the
    /// start.
    pub(super) time: u64,
}

/// The index of a track.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Index {
    pub(super) samples: Vec<Sample>,
    pub(super) configurations: Vec<AvcConfiguration>,
    pub(super) ticks_per_second: u32,
    pub(super) rotation: Rotation,
}

/// An index that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum IndexError {
    /// The kind of the file is not supported.
    Unsupported { what: String, remedy: &'static str },
    /// The index is damaged.
    Malformed(&'static str),
}

const REENCODE: &str = "Convert it: ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p OUT.mp4";

/// The part of the track that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Edit {
    /// First tick shown.
    from: i64,
    /// First tick that is not shown any more.
    until: Option<i64>,
    /// Ticks of the pause before it.
    pause: i64,
}

impl Index {
    /// Reads the content of the `moov` box and of the `moof` boxes, each with its offset in the file.
    pub(super) fn parse(moov: &[u8], fragments: &[(u64, Vec<u8>)]) -> Result<Self, IndexError> {
        let trak = video_track(moov)?;
        let malformed = IndexError::Malformed;
        let media = Boxes::new(trak).find(b"mdia").ok_or(malformed("the track has no media"))?;
        let ticks_per_second = timescale(Boxes::new(media).find(b"mdhd"), 12, 20)
            .ok_or(malformed("the track has no time scale"))?;
        let table = Boxes::new(media).path(&[b"minf", b"stbl"]).ok_or(malformed("the track has no index"))?;
        let table = Boxes::new(table);
        let configurations = configurations(table)?;
        let (rotation, track) = track_header(trak)?;
        let mut raw = table_samples(table).ok_or(malformed("the index of the track is damaged"))?;
        let mut clock = 0;
        for (start, content) in fragments {
            append_fragment(moov, content, *start, track, &mut clock, &mut raw)
                .ok_or(malformed("the index of a fragment is damaged"))?;
        }
        if raw.iter().any(|sample| usize::from(sample.configuration) >= configurations.len()) {
            return Err(malformed("a picture refers to decoder parameters that are not there"));
        }
        let edit = edit_of(moov, trak, ticks_per_second)?;
        Ok(Self { samples: apply_edit(&raw, edit), configurations, ticks_per_second, rotation })
    }
}

/// The first track with H.264 video; an error names other video. A track that is switched off, such as a
/// preview, is read only where every one is.
fn video_track(moov: &[u8]) -> Result<&[u8], IndexError> {
    let video = || Boxes::new(moov).of_kind(b"trak").filter(|trak| is_video(trak));
    let are_all_off = !video().any(is_enabled);
    let mut tracks = video().filter(|trak| are_all_off || is_enabled(trak)).peekable();
    let first = tracks.peek().copied();
    if let Some(trak) = tracks.find(|trak| sample_kind(trak).is_some_and(|kind| is_avc(&kind))) {
        return Ok(trak);
    }
    let what = match first.map(sample_kind) {
        None => "an MP4 file without a video track".to_owned(),
        Some(None) => return Err(IndexError::Malformed("the video track does not say its codec")),
        Some(Some(kind)) => format!("an MP4 file with {} video", codec_name(&kind)),
    };
    Err(IndexError::Unsupported { what, remedy: REENCODE })
}

fn is_video(trak: &[u8]) -> bool {
    let handler = Boxes::new(trak).path(&[b"mdia", b"hdlr"]);
    handler.and_then(|handler| handler.get(8..12)) == Some(b"vide")
}

/// The flag `Track_enabled` of the track's header (8.3.2).
fn is_enabled(trak: &[u8]) -> bool {
    Boxes::new(trak).find(b"tkhd").and_then(|header| header.get(3)).is_some_and(|flags| flags & 1 == 1)
}

/// The codec of a track.
fn sample_kind(trak: &[u8]) -> Option<BoxKind> {
    let entries = Boxes::new(trak).path(&[b"mdia", b"minf", b"stbl", b"stsd"])?;
    Boxes::new(entries.get(8..)?).next().map(|(kind, _)| kind)
}

fn is_avc(kind: &BoxKind) -> bool {
    matches!(kind, b"avc1" | b"avc3")
}

fn codec_name(kind: &BoxKind) -> String {
    let name = match kind {
        b"hvc1" | b"hev1" | b"dvh1" | b"dvhe" => "HEVC (H.265)",
        b"av01" => "AV1",
        b"vp08" => "VP8",
        b"vp09" => "VP9",
        b"mp4v" => "MPEG-4 part 2 (or MPEG-2)",
        b"jpeg" | b"mjpa" | b"mjpb" => "Motion JPEG",
        b"ap4h" | b"ap4x" | b"apch" | b"apcn" | b"apcs" | b"apco" => "ProRes",
        b"encv" => "encrypted",
        _ => return format!("`{}`", kind.escape_ascii()),
    };
    name.to_owned()
}

/// The ticks per second of a header box; the offset of the field depends on the version.
fn timescale(header: Option<&[u8]>, at: usize, at_version_1: usize) -> Option<u32> {
    let header = header?;
    let at = if *header.first()? == 1 { at_version_1 } else { at };
    let ticks = u32::from_be_bytes(header.get(at..at + 4)?.try_into().ok()?);
    (ticks > 0).then_some(ticks)
}

fn configurations(table: Boxes<'_>) -> Result<Vec<AvcConfiguration>, IndexError> {
    /// Bytes of a visual sample entry before its boxes.
    const ENTRY_HEADER: usize = 78;
    let malformed = IndexError::Malformed("the decoder parameters (avcC) are damaged");
    let entries = table.find(b"stsd").and_then(|stsd| stsd.get(8..)).ok_or(malformed.clone())?;
    let mut found = Vec::new();
    for (kind, entry) in Boxes::new(entries) {
        if !is_avc(&kind) {
            let what = format!("an MP4 file that changes to {} video", codec_name(&kind));
            return Err(IndexError::Unsupported { what, remedy: REENCODE });
        }
        let avc = entry.get(ENTRY_HEADER..).and_then(|boxes| Boxes::new(boxes).find(b"avcC"));
        found.push(avc.and_then(AvcConfiguration::parse).ok_or(malformed.clone())?);
    }
    if found.is_empty() { Err(malformed) } else { Ok(found) }
}

/// The rotation of the picture and the number of the track.
fn track_header(trak: &[u8]) -> Result<(Rotation, u32), IndexError> {
    let read = || {
        let header = Boxes::new(trak).find(b"tkhd")?;
        let mut fields = Fields::new(header);
        let (version, _) = fields.version_and_flags()?;
        fields.skip(if version == 1 { 16 } else { 8 })?;
        let track = fields.u32()?;
        fields.skip(if version == 1 { 28 } else { 24 })?;
        let (a, b) = (fields.i32()?, fields.i32()?);
        fields.skip(4)?;
        Some((track, [a, b, fields.i32()?, fields.i32()?]))
    };
    let (track, matrix) = read().ok_or(IndexError::Malformed("the header of the track is damaged"))?;
    // (p, q) is displayed at (a p + c q, b p + d q), with q downwards.
    let rotation = match matrix.map(i32::signum) {
        [1, 0, 0, 1] | [0, 0, 0, 0] => Rotation::None,
        [0, 1, -1, 0] => Rotation::Clockwise90,
        [-1, 0, 0, -1] => Rotation::Half,
        [0, -1, 1, 0] => Rotation::Clockwise270,
        _ => {
            let what = "an MP4 file that is shown mirrored or aslant".to_owned();
            return Err(IndexError::Unsupported { what, remedy: REENCODE });
        }
    };
    Ok((rotation, track))
}

/// The edit list (8.6.6) as one shown part after a pause.
fn edit_of(moov: &[u8], trak: &[u8], ticks_per_second: u32) -> Result<Option<Edit>, IndexError> {
    let Some(list) = Boxes::new(trak).path(&[b"edts", b"elst"]) else { return Ok(None) };
    let malformed = || IndexError::Malformed("the edit list is damaged");
    let film_ticks = timescale(Boxes::new(moov).find(b"mvhd"), 12, 20).ok_or_else(malformed)?;
    let in_track = |film: u64| {
        let ticks = (u128::from(film) * u128::from(ticks_per_second)).div_ceil(u128::from(film_ticks));
        i64::try_from(ticks).ok()
    };
    let mut fields = Fields::new(list);
    let (version, _) = fields.version_and_flags().ok_or_else(malformed)?;
    let count = fields.u32().ok_or_else(malformed)?;
    let mut edit: Option<Edit> = None;
    let mut pause = 0_i64;
    for _ in 0..count {
        let read = |fields: &mut Fields<'_>| {
            let lasts = in_track(fields.wide(version)?)?;
            let from = match version {
                1 => fields.u64()? as i64,
                _ => i64::from(fields.i32()?),
            };
            Some((lasts, from, fields.u32()?))
        };
        let (lasts, from, speed) = read(&mut fields).ok_or_else(malformed)?;
        if from < 0 {
            if edit.is_none() {
                pause = pause.saturating_add(lasts);
            }
            continue;
        }
        if edit.is_some() || speed != 0x0001_0000 {
            let what =
                "an MP4 file that is cut from several pieces, or slowed down, by its edit list".to_owned();
            return Err(IndexError::Unsupported { what, remedy: REENCODE });
        }
        let until = (lasts > 0).then(|| from.saturating_add(lasts));
        edit = Some(Edit { from, until, pause });
    }
    Ok(edit)
}

fn apply_edit(raw: &[RawSample], edit: Option<Edit>) -> Vec<Sample> {
    // Without an edit list the video starts at tick 0, or at the first picture if that is earlier.
    let first = raw.iter().map(|sample| sample.time).min().unwrap_or(0);
    let edit = edit.unwrap_or(Edit { from: first.min(0), until: None, pause: 0 });
    raw.iter()
        .map(|sample| Sample {
            offset: sample.offset,
            size: sample.size,
            configuration: sample.configuration,
            shown: sample.time >= edit.from && edit.until.is_none_or(|until| sample.time < until),
            time: u64::try_from(sample.time.saturating_sub(edit.from).saturating_add(edit.pause))
                .unwrap_or(0),
        })
        .collect()
}
