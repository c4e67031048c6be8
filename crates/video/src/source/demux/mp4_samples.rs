//! Reads where the pictures of an MP4 track are, and when they are shown: from the tables of the track
//! (ISO/IEC 14496-12, 8.6 and 8.7), and from fragments (8.8).

use super::mp4_boxes::{Boxes, Fields};

/// Maximum number of pictures in a file: 37 hours at 30 per second. A larger number counts as damage.
const MAX_SAMPLES: usize = 4_000_000;

/// A sample before the edit list is applied; times in ticks of the track.
pub(super) struct RawSample {
    pub(super) offset: u64,
    pub(super) size: u32,
    pub(super) configuration: u16,
    pub(super) time: i64,
}

/// All samples of the tables in `stbl` (8.6 and 8.7); none if the file is fragmented.
pub(super) fn table_samples(table: Boxes<'_>) -> Option<Vec<RawSample>> {
    let sizes = sample_sizes(table.find(b"stsz")?)?;
    if sizes.is_empty() {
        return Some(Vec::new());
    }
    let offsets: Vec<u64> = match table.find(b"stco") {
        Some(stco) => {
            full_table(stco, 4)?.map(|mut entry| entry.u32().map(u64::from)).collect::<Option<_>>()?
        }
        None => full_table(table.find(b"co64")?, 8)?.map(|mut entry| entry.u64()).collect::<Option<_>>()?,
    };
    let mut runs = Vec::new();
    for mut entry in full_table(table.find(b"stsc")?, 12)? {
        runs.push((entry.u32()?, entry.u32()?, entry.u32()?));
    }
    let durations = run_lengths(table.find(b"stts")?)?;
    let shifts = table.find(b"ctts").map(run_lengths).unwrap_or(Some(Vec::new()))?;
    let (mut durations, mut shifts) = (RunLengthIter::new(&durations), RunLengthIter::new(&shifts));
    let mut samples = Vec::with_capacity(sizes.len());
    let mut sizes = sizes.into_iter();
    let mut run = runs.iter().peekable();
    let mut current = None;
    let mut decoded_at = 0_i64;
    for (chunk, offset) in (1_u32..).zip(offsets) {
        if let Some(next) = run.next_if(|(first, _, _)| *first <= chunk) {
            current = Some(*next);
        }
        let (_, per_chunk, configuration) = current?;
        let configuration = u16::try_from(configuration.checked_sub(1)?).ok()?;
        let mut offset = offset;
        for _ in 0..per_chunk {
            let Some(size) = sizes.next() else { return Some(samples) };
            let time = decoded_at.checked_add(i64::from(shifts.next().unwrap_or(0) as i32))?;
            samples.push(RawSample { offset, size, configuration, time });
            offset = offset.checked_add(u64::from(size))?;
            decoded_at = decoded_at.checked_add(i64::from(durations.next().unwrap_or(0)))?;
        }
    }
    // A file that was truncated while it was written has sizes without offsets.
    Some(samples)
}

fn sample_sizes(stsz: &[u8]) -> Option<Vec<u32>> {
    let mut fields = Fields::new(stsz);
    fields.skip(4)?;
    let (common, count) = (fields.u32()?, fields.u32()? as usize);
    if common != 0 {
        return (count <= MAX_SAMPLES).then(|| vec![common; count]);
    }
    if fields.left() / 4 < count || count > MAX_SAMPLES {
        return None;
    }
    (0..count).map(|_| fields.u32()).collect()
}

/// The entries of a table whose count follows version and flags.
fn full_table(content: &[u8], entry: usize) -> Option<impl Iterator<Item = Fields<'_>>> {
    let mut fields = Fields::new(content);
    fields.skip(4)?;
    let count = fields.u32()? as usize;
    if fields.left() / entry < count {
        return None;
    }
    Some(fields.rest().chunks_exact(entry).take(count).map(Fields::new))
}

/// Pairs of a count and a value.
fn run_lengths(content: &[u8]) -> Option<Vec<(u32, u32)>> {
    full_table(content, 8)?.map(|mut entry| entry.u32().zip(entry.u32())).collect()
}

/// Iterates over the values of a run-length code.
struct RunLengthIter<'a> {
    runs: std::slice::Iter<'a, (u32, u32)>,
    left: u32,
    value: u32,
}

impl<'a> RunLengthIter<'a> {
    fn new(runs: &'a [(u32, u32)]) -> Self {
        Self { runs: runs.iter(), left: 0, value: 0 }
    }

    fn next(&mut self) -> Option<u32> {
        while self.left == 0 {
            (self.left, self.value) = *self.runs.next()?;
        }
        self.left -= 1;
        Some(self.value)
    }
}

/// Appends the samples of one `moof` (8.8). `clock` is the end time of the fragment before it.
pub(super) fn append_fragment(
    moov: &[u8],
    moof: &[u8],
    moof_start: u64,
    track: u32,
    clock: &mut i64,
    samples: &mut Vec<RawSample>,
) -> Option<()> {
    let extends = Boxes::new(moov).find(b"mvex").map(Boxes::new);
    let defaults = extends
        .and_then(|boxes| boxes.of_kind(b"trex").find(|trex| trex.get(4..8) == Some(&track.to_be_bytes())));
    for traf in Boxes::new(moof).of_kind(b"traf").map(Boxes::new) {
        let mut header = Fields::new(traf.find(b"tfhd")?);
        let (_, flags) = header.version_and_flags()?;
        if header.u32()? != track {
            continue;
        }
        let mut trex = Fields::new(defaults.and_then(|trex| trex.get(8..)).unwrap_or(&[0; 12]));
        let base = if flags & 0x1 != 0 { header.u64()? } else { moof_start };
        let mut or_default = |flag: u32| {
            let default = trex.u32();
            if flags & flag != 0 { header.u32() } else { default }
        };
        let configuration = u16::try_from(or_default(0x2)?.max(1) - 1).ok()?;
        let (duration, size) = (or_default(0x8)?, or_default(0x10)?);
        if let Some(time) = traf.find(b"tfdt") {
            let mut time = Fields::new(time);
            let (version, _) = time.version_and_flags()?;
            *clock = i64::try_from(time.wide(version)?).ok()?;
        }
        let mut offset = base;
        for run in traf.of_kind(b"trun") {
            let mut run = Fields::new(run);
            let (_, flags) = run.version_and_flags()?;
            let count = run.u32()? as usize;
            if flags & 0x1 != 0 {
                offset = base.checked_add_signed(i64::from(run.i32()?))?;
            }
            if flags & 0x4 != 0 {
                run.skip(4)?;
            }
            if samples.len().saturating_add(count) > MAX_SAMPLES {
                return None;
            }
            for _ in 0..count {
                let duration = if flags & 0x100 != 0 { run.u32()? } else { duration };
                let size = if flags & 0x200 != 0 { run.u32()? } else { size };
                if flags & 0x400 != 0 {
                    run.skip(4)?;
                }
                let shift = if flags & 0x800 != 0 { run.i32()? } else { 0 };
                let time = clock.checked_add(i64::from(shift))?;
                samples.push(RawSample { offset, size, configuration, time });
                offset = offset.checked_add(u64::from(size))?;
                *clock = clock.checked_add(i64::from(duration))?;
            }
        }
    }
    Some(())
}
