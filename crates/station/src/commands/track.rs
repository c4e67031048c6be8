//! `barrelman track`: runs the tracker alone on a recorded video.

use std::io::{BufWriter, Write, stdout};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use barrelman_vision::{Explanation, Tracker};
use barrelman_vocab::{Track, VehicleProfile, VideoFrame};
use indicatif::{ProgressBar, ProgressStyle};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

use crate::cli::TrackArgs;
use barrelman_experiments::tracker_choice::TrackerSettings;
use barrelman_host::output::OutputFile;
use barrelman_overlay::film::Film;
use barrelman_video::{DecodeError, FileFrames, VideoError, VideoUrl};

/// The header of `track.csv`.
pub const HEADER: &str =
    "frame,time_s,state,x,y,w,h,cx,cy,major_px,minor_px,angle_deg,heading_deg,confidence";

#[derive(Serialize)]
struct Figures {
    frames: u64,
    lost_frames: u64,
    coasting_frames: u64,
    damaged_pictures: u64,
    tracker: &'static str,
    tracker_cpu_ms: Percentiles,
    decode_cpu_ms: Percentiles,
}

/// Median and 99th percentile, milliseconds; `null` without values.
#[derive(Serialize)]
struct Percentiles {
    median: Option<f64>,
    p99: Option<f64>,
}

impl Percentiles {
    fn from_times(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let percentile = |share: f64| {
            let index = (times.len().checked_sub(1)? as f64 * share).round() as usize;
            Some(times[index].as_secs_f64() * 1e3)
        };
        Self { median: percentile(0.5), p99: percentile(0.99) }
    }
}

/// Runs the command.
///
/// # Errors
/// If the video, the selection or an output cannot be used. The track before an error in the video is kept.
pub fn run(args: &TrackArgs) -> Result<ExitCode> {
    let url = VideoUrl::parse(&args.video)?;
    let open =
        |path: &Option<PathBuf>| path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose();
    let (rows, film) = (open(&args.output)?, open(&args.overlay)?);
    let rows: Box<dyn Write> = match rows {
        Some(file) => Box::new(file),
        // With --json only the figures are printed.
        None if args.json => Box::new(std::io::sink()),
        None => Box::new(stdout().lock()),
    };
    let mut frames = FileFrames::open(&url)?;
    let mut track = TrackWriter {
        tracker: TrackerSettings::of(args.tracker).tracker()?,
        rows: BufWriter::new(rows),
        has_rows: false,
        film: film.map(|file| Film::new(file, VehicleProfile::fotokite_pro().region)),
        explanation: args.explain.then(Explanation::default),
        lost: 0,
        coasting: 0,
        tracker_times: Vec::new(),
    };
    let progress = progress_bar(&frames);
    let mut decode_times = Vec::new();
    let (mut index, mut damaged) = (0_u64, 0_u64);
    let failure = loop {
        let before = cpu_time();
        let frame = match frames.next_frame() {
            Ok(Some(frame)) => frame,
            Ok(None) => break None,
            Err(VideoError::Decode { cause: cause @ DecodeError::Damaged { .. }, .. }) => {
                damaged += 1;
                if damaged == 1 {
                    tracing::warn!("{cause}; further damage is counted");
                }
                continue;
            }
            Err(error) => break Some(error),
        };
        decode_times.push(cpu_time().saturating_sub(before));
        if index >= args.start_frame {
            track.add(args, index, &frame)?;
        }
        index += 1;
        progress.inc(1);
    };
    progress.finish_and_clear();
    track.rows.flush().context("the track cannot be written")?;
    if index <= args.start_frame && failure.is_none() {
        bail!("{url} has {index} frames: there is no start frame {}", args.start_frame);
    }
    let (lost_frames, coasting_frames) = (track.lost, track.coasting);
    let tracker_times = std::mem::take(&mut track.tracker_times);
    if let Some(film) = track.film {
        film.finish()?;
    }
    if damaged > 1 {
        tracing::warn!("{damaged} damaged pictures in total");
    }
    if args.json {
        let figures = Figures {
            frames: index.saturating_sub(args.start_frame),
            lost_frames,
            coasting_frames,
            damaged_pictures: damaged,
            tracker: args.tracker.word(),
            tracker_cpu_ms: Percentiles::from_times(tracker_times),
            decode_cpu_ms: Percentiles::from_times(decode_times),
        };
        writeln!(stdout(), "{}", serde_json::to_string_pretty(&figures)?)?;
    }
    match failure {
        Some(error) => {
            Err(error).context(format!("the error came after {index} frames, whose track was kept"))
        }
        None => Ok(ExitCode::SUCCESS),
    }
}

/// CPU time of all threads of the program. While the tracker runs, no other thread does, so a difference is the tracker's.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // CPU time counts from zero: neither part is negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

fn progress_bar(frames: &FileFrames) -> ProgressBar {
    let style = "{bar:40} {pos}/{len} frames, {eta} left";
    match (frames.frame_count(), ProgressStyle::with_template(style)) {
        (Some(count), Ok(style)) => ProgressBar::new(count).with_style(style),
        _ => ProgressBar::new_spinner(),
    }
}

/// Tracks frame by frame, and writes the rows and the film.
struct TrackWriter {
    tracker: Box<dyn Tracker>,
    rows: BufWriter<Box<dyn Write>>,
    /// Whether the header is written. The header comes with the first row, so that a refused selection leaves no file
    /// behind.
    has_rows: bool,
    film: Option<Film>,
    explanation: Option<Explanation>,
    lost: u64,
    coasting: u64,
    tracker_times: Vec<Duration>,
}

impl TrackWriter {
    fn add(&mut self, args: &TrackArgs, index: u64, frame: &VideoFrame) -> Result<()> {
        let before = cpu_time();
        let track = if index == args.start_frame {
            let report = self.tracker.select(frame, args.select)?;
            if report.is_clipped {
                tracing::warn!(
                    "the selection lies partly outside the picture: {} of it is used",
                    report.used
                );
            }
            Track::Tracking(report.localisation)
        } else {
            let track = self.tracker.track(frame, None);
            self.tracker_times.push(cpu_time().saturating_sub(before));
            track
        };
        self.lost += u64::from(matches!(track, Track::Lost { .. }));
        self.coasting += u64::from(matches!(track, Track::Coasting(_)));
        if !std::mem::replace(&mut self.has_rows, true) {
            writeln!(self.rows, "{HEADER}")?;
        }
        write_row(&mut self.rows, index, frame.capture.at.as_secs_f64(), &track)?;
        if let Some(film) = &mut self.film {
            if let Some(explanation) = &mut self.explanation {
                self.tracker.explain(explanation);
            }
            film.add_track(frame, &track, self.explanation.as_ref())?;
        }
        Ok(())
    }
}

/// Writes one row of `track.csv`.
fn write_row(output: &mut impl Write, index: u64, time_s: f64, track: &Track) -> std::io::Result<()> {
    let (state, seen, confidence) = match track {
        Track::Tracking(seen) => ("tracking", seen, seen.confidence),
        Track::Coasting(seen) => ("coasting", seen, seen.confidence),
        Track::Lost { confidence, .. } => {
            return writeln!(output, "{index},{time_s:.6},lost,,,,,,,,,,,{confidence:.4}");
        }
        // There are no rows before the selection.
        Track::Unseeded => return Ok(()),
    };
    let (bounds, centre) = (seen.bounds, seen.centre);
    write!(
        output,
        "{index},{time_s:.6},{state},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},",
        bounds.u, bounds.v, bounds.w, bounds.h, centre.u, centre.v
    )?;
    match seen.shape {
        Some(shape) => {
            write!(output, "{:.3},{:.3},{:.3},", shape.major_px, shape.minor_px, shape.axis.degrees())?;
        }
        None => write!(output, ",,,")?,
    }
    match seen.heading {
        Some(heading) => write!(output, "{:.3},", heading.degrees())?,
        None => write!(output, ",")?,
    }
    writeln!(output, "{confidence:.4}")
}
