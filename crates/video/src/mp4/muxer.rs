//! Writes access units to an MP4 file (ISO/IEC 14496-12 and -15): one video track, the samples in the order
//! of their arrival, and the index (`moov`) after them when the file is finished.
//!
//! Only the index is held in memory, 24 bytes per picture. Times are those of the samples, in ticks of
//! 1/90000 s, so the frame rate may vary; the video starts with the earliest picture. Where display order and
//! decoding order differ, the file has composition offsets (`ctts`) and an edit list. Where the stream
//! changes its parameter sets (for instance its size), the new ones stay in the samples. Not handled: sound,
//! fragments.

use std::io::{self, Seek, SeekFrom, Write};
use std::time::Duration;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;

use crate::codec::annexb::{self, NalKind};
use barrelman_vocab::unit::Rotation;

/// Ticks per second of the track and of the file.
const TICKS_PER_SECOND: u32 = 90_000;

/// The boxes before the samples: `ftyp`, and the `mdat` header with a length of 64 bits.
const FILE_TYPE: &[u8] = b"\0\0\0\x20ftypisom\0\0\x02\0isomiso2avc1mp41";
const MEDIA_HEADER: u64 = 16;

/// The properties of the whole track.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TrackFormat {
    /// Size of the stored picture.
    pub(super) size: PictureSize,
    /// Rotation for display.
    pub(super) rotation: Rotation,
    /// The sequence parameter set, without a start code.
    pub(super) sps: Vec<u8>,
    /// The picture parameter set, without a start code.
    pub(super) pps: Vec<u8>,
}

struct Sample {
    size: u32,
    key: bool,
    at: Timestamp,
}

/// Writes one MP4 file.
pub(super) struct Mp4Muxer<W: Write + Seek> {
    out: W,
    format: TrackFormat,
    samples: Vec<Sample>,
    media_bytes: u64,
    /// Whether the stream has changed its parameter sets. From then on all parameter sets stay in the
    /// samples.
    has_new_parameters: bool,
    buffer: Vec<u8>,
}

impl<W: Write + Seek> Mp4Muxer<W> {
    /// Begins a file.
    pub(super) fn new(mut out: W, format: TrackFormat) -> io::Result<Self> {
        out.write_all(FILE_TYPE)?;
        out.write_all(b"\0\0\0\x01mdat\0\0\0\0\0\0\0\0")?;
        Ok(Self {
            out,
            format,
            samples: Vec::new(),
            media_bytes: 0,
            has_new_parameters: false,
            buffer: Vec::new(),
        })
    }

    /// Appends an access unit (Annex B). Parameter sets that are in the index are left out of the sample.
    pub(super) fn push(&mut self, unit: &[u8], key: bool, at: Timestamp) -> io::Result<()> {
        self.buffer.clear();
        for nal in annexb::nals(unit) {
            let is_known = match annexb::kind(nal) {
                NalKind::Sps => nal == self.format.sps,
                NalKind::Pps => nal == self.format.pps,
                _ => true,
            };
            self.has_new_parameters |= !is_known;
            let in_index =
                matches!(annexb::kind(nal), NalKind::Sps | NalKind::Pps) && !self.has_new_parameters;
            if !in_index {
                self.buffer.extend_from_slice(&checked_u32(nal.len())?.to_be_bytes());
                self.buffer.extend_from_slice(nal);
            }
        }
        self.out.write_all(&self.buffer)?;
        self.samples.push(Sample { size: checked_u32(self.buffer.len())?, key, at });
        self.media_bytes += self.buffer.len() as u64;
        Ok(())
    }

    /// Writes the index. The last picture is shown as long as the picture before it; a single picture for
    /// `single_duration`.
    pub(super) fn finish(mut self, single_duration: Duration) -> io::Result<W> {
        let moov = self.index(single_duration)?;
        self.out.write_all(&moov)?;
        self.out.seek(SeekFrom::Start(FILE_TYPE.len() as u64 + 8))?;
        self.out.write_all(&(MEDIA_HEADER + self.media_bytes).to_be_bytes())?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn index(&self, single_duration: Duration) -> io::Result<Vec<u8>> {
        let times = SampleTimes::new(&self.samples, single_duration);
        let (duration, size) = (times.duration, self.format.size);
        let mut moov = BoxWriter::default();
        moov.boxed(b"moov", |moov| {
            moov.full(b"mvhd", 1, 0, |b| {
                b.zeros(16).u32(TICKS_PER_SECOND).u64(duration).u32(0x0001_0000).u16(0x0100).zeros(10);
                b.matrix(Rotation::None, size).zeros(24).u32(2);
            });
            moov.boxed(b"trak", |trak| {
                trak.full(b"tkhd", 1, 3, |b| {
                    b.zeros(16).u32(1).zeros(4).u64(duration).zeros(16);
                    b.matrix(self.format.rotation, size);
                    b.u32(size.width << 16).u32(size.height << 16);
                });
                if times.delay > 0 {
                    trak.boxed(b"edts", |edts| {
                        edts.full(b"elst", 1, 0, |b| {
                            b.u32(1).u64(duration).u64(times.delay).u32(0x0001_0000);
                        });
                    });
                }
                trak.boxed(b"mdia", |mdia| self.media(mdia, &times));
            });
        });
        checked_u32(moov.bytes.len())?;
        Ok(moov.bytes)
    }

    fn media(&self, mdia: &mut BoxWriter, times: &SampleTimes) {
        mdia.full(b"mdhd", 1, 0, |b| {
            // 0x55c4 is "und": the language is undetermined.
            b.zeros(16).u32(TICKS_PER_SECOND).u64(times.duration).u16(0x55c4).zeros(2);
        });
        mdia.full(b"hdlr", 0, 0, |b| {
            b.zeros(4).raw(b"vide").zeros(12).raw(b"VideoHandler\0");
        });
        mdia.boxed(b"minf", |minf| {
            minf.full(b"vmhd", 0, 1, |b| {
                b.zeros(8);
            });
            minf.boxed(b"dinf", |dinf| {
                dinf.full(b"dref", 0, 0, |b| {
                    b.u32(1);
                    // Flag 1: the samples are in this file.
                    b.full(b"url ", 0, 1, |_| {});
                });
            });
            minf.boxed(b"stbl", |stbl| self.table(stbl, times));
        });
    }

    fn table(&self, stbl: &mut BoxWriter, times: &SampleTimes) {
        let count = self.samples.len() as u32;
        stbl.full(b"stsd", 0, 0, |b| {
            b.u32(1);
            b.boxed(b"avc1", |avc1| self.sample_entry(avc1));
        });
        stbl.full(b"stts", 0, 0, |b| b.runs(&times.durations));
        if times.delay > 0 {
            stbl.full(b"ctts", 0, 0, |b| b.runs(&times.shifts));
        }
        if self.samples.iter().any(|sample| !sample.key) {
            let keys: Vec<u32> =
                (1..).zip(&self.samples).filter(|(_, sample)| sample.key).map(|(number, _)| number).collect();
            stbl.full(b"stss", 0, 0, |b| {
                b.u32(keys.len() as u32);
                keys.iter().for_each(|key| {
                    b.u32(*key);
                });
            });
        }
        // The samples are contiguous: one chunk.
        stbl.full(b"stsc", 0, 0, |b| {
            b.u32(1).u32(1).u32(count).u32(1);
        });
        stbl.full(b"stsz", 0, 0, |b| {
            b.u32(0).u32(count);
            self.samples.iter().for_each(|sample| {
                b.u32(sample.size);
            });
        });
        stbl.full(b"stco", 0, 0, |b| {
            b.u32(1).u32(FILE_TYPE.len() as u32 + MEDIA_HEADER as u32);
        });
    }

    fn sample_entry(&self, avc1: &mut BoxWriter) {
        let TrackFormat { size, sps, pps, .. } = &self.format;
        avc1.zeros(6).u16(1).zeros(16).u16(size.width as u16).u16(size.height as u16);
        // 72 dots per inch both ways, one frame a sample, no name, 24 bits deep.
        avc1.u32(0x0048_0000).u32(0x0048_0000).zeros(4).u16(1).zeros(32).u16(24).u16(0xffff);
        avc1.boxed(b"avcC", |b| {
            let profile = |at: usize| sps.get(at).copied().unwrap_or(0);
            b.raw(&[1, profile(1), profile(2), profile(3), 0xff, 0xe1]);
            b.u16(sps.len() as u16).raw(sps).raw(&[1]).u16(pps.len() as u16).raw(pps);
            if matches!(profile(1), 100 | 110 | 122 | 144) {
                // 4:2:0, 8 bit: the only formats that the crate supports.
                b.raw(&[0xfd, 0xf8, 0xf8, 0]);
            }
        });
    }
}

fn checked_u32(bytes: usize) -> io::Result<u32> {
    u32::try_from(bytes).map_err(|_| io::Error::other("a picture or the index takes more than 4 GiB"))
}

/// Decoding and display times of the samples.
struct SampleTimes {
    /// Ticks from one decoding time to the next, run-length coded: count and value.
    durations: Vec<(u32, u32)>,
    /// Ticks from decoding to display, run-length coded: count and value.
    shifts: Vec<(u32, u32)>,
    /// Ticks added to all shifts, so that no shift is negative.
    delay: u64,
    /// Duration of the video, ticks.
    duration: u64,
}

impl SampleTimes {
    fn new(samples: &[Sample], single_duration: Duration) -> Self {
        let ticks = |duration: Duration| {
            (duration.as_nanos() * u128::from(TICKS_PER_SECOND) + 500_000_000) / 1_000_000_000
        };
        let start = samples.iter().map(|sample| sample.at).min().unwrap_or_default();
        // Display order. Two pictures with the same time are put one tick apart.
        let mut order: Vec<usize> = (0..samples.len()).collect();
        order.sort_by_key(|index| samples[*index].at);
        let mut shown_at = vec![0_u64; samples.len()];
        let mut decoded_at = Vec::with_capacity(samples.len());
        for index in order {
            let wanted = u64::try_from(ticks(samples[index].at.since(start))).unwrap_or(u64::MAX);
            let earliest = decoded_at.last().map_or(0, |before: &u64| before + 1);
            shown_at[index] = wanted.max(earliest);
            decoded_at.push(shown_at[index]);
        }
        // The decoding times are the display times, in ascending order.
        let late = |(decoded, shown): (&u64, &u64)| decoded.saturating_sub(*shown);
        let delay = decoded_at.iter().zip(&shown_at).map(late).max().unwrap_or(0);
        let gaps: Vec<u64> = decoded_at.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let single = u64::try_from(ticks(single_duration)).unwrap_or(0).max(1);
        let last = gaps.last().copied().unwrap_or(single);
        let duration = decoded_at.last().map_or(0, |start| start + last);
        let shifts = decoded_at.iter().zip(&shown_at).map(|(decoded, shown)| shown + delay - decoded);
        Self {
            durations: run_lengths(gaps.iter().copied().chain([last])),
            shifts: run_lengths(shifts),
            delay,
            duration,
        }
    }
}

fn run_lengths(values: impl Iterator<Item = u64>) -> Vec<(u32, u32)> {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for value in values {
        let value = u32::try_from(value).unwrap_or(u32::MAX);
        match runs.last_mut() {
            Some((count, last)) if *last == value => *count += 1,
            _ => runs.push((1, value)),
        }
    }
    runs
}

/// Writes boxes to memory.
#[derive(Default)]
struct BoxWriter {
    bytes: Vec<u8>,
}

impl BoxWriter {
    fn boxed(&mut self, kind: &[u8; 4], content: impl FnOnce(&mut Self)) {
        let start = self.bytes.len();
        self.u32(0).raw(kind);
        content(self);
        let size = (self.bytes.len() - start) as u32;
        self.bytes[start..start + 4].copy_from_slice(&size.to_be_bytes());
    }

    fn full(&mut self, kind: &[u8; 4], version: u8, flags: u32, content: impl FnOnce(&mut Self)) {
        self.boxed(kind, |b| {
            b.u32(u32::from(version) << 24 | flags);
            content(b);
        });
    }

    fn runs(&mut self, runs: &[(u32, u32)]) {
        self.u32(runs.len() as u32);
        for (count, value) in runs {
            self.u32(*count).u32(*value);
        }
    }

    /// The matrix of a rotation: (p, q) is displayed at (a p + c q + x, b p + d q + y), with q downwards.
    fn matrix(&mut self, rotation: Rotation, stored: PictureSize) -> &mut Self {
        const ONE: i32 = 0x0001_0000;
        let (width, height) = ((stored.width as i32) << 16, (stored.height as i32) << 16);
        let (a, b, c, d, x, y) = match rotation {
            Rotation::None => (ONE, 0, 0, ONE, 0, 0),
            Rotation::Clockwise90 => (0, ONE, -ONE, 0, height, 0),
            Rotation::Half => (-ONE, 0, 0, -ONE, width, height),
            Rotation::Clockwise270 => (0, -ONE, ONE, 0, 0, width),
        };
        for value in [a, b, 0, c, d, 0, x, y, 0x4000_0000] {
            self.u32(value as u32);
        }
        self
    }

    fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    fn zeros(&mut self, count: usize) -> &mut Self {
        self.bytes.resize(self.bytes.len() + count, 0);
        self
    }

    fn u16(&mut self, value: u16) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }

    fn u64(&mut self, value: u64) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }
}
