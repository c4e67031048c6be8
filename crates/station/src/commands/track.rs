//! `barrelman track`: runs the tracker alone on a recorded video.

use std::io::{BufWriter, Write, stdout};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use barrelman_console_server::{AfterPicking, ConsoleAddress, ConsoleSettings, KeptTokens};
use barrelman_vision::{Explanation, Tracker};
use barrelman_vocab::{PixelBox, Track, VehicleProfile, VideoFrame};
use indicatif::{ProgressBar, ProgressStyle};
use rustix::time::{ClockId, clock_gettime};

use super::draw_selection::{draw_selection, has_display};
use super::track_figures::{TrackFigures, TrackTotals, selection_warnings};
use crate::cli::{TrackArgs, UsageError};
use crate::interruption::flag_of_signals;
use barrelman_experiments::tracker_choice::TrackerSettings;
use barrelman_host::output::OutputFile;
use barrelman_overlay::film::Film;
use barrelman_video::{DecodeError, VideoError, VideoFrames, VideoUrl};

/// The header of `track.csv`.
pub const HEADER: &str =
    "frame,time_s,state,x,y,w,h,cx,cy,major_px,minor_px,angle_deg,heading_deg,confidence";

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
    let selection = match args.select {
        Some(selection) => selection,
        None => drawn_selection(args, &url)?,
    };
    let mut frames = VideoFrames::open(&url)?;
    let mut track = TrackWriter {
        tracker: TrackerSettings::new(args.tracker).build()?,
        rows: BufWriter::new(rows),
        has_rows: false,
        film: film.map(|file| Film::new(file, VehicleProfile::fotokite_pro().region)),
        explanation: args.explain.then(Explanation::default),
        totals: TrackTotals::default(),
    };
    let Followed { frames: index, damaged, decode_times, failure } =
        follow(args, selection, &mut frames, &mut track)?;
    track.rows.flush().context("the track cannot be written")?;
    if index <= args.start_frame && failure.is_none() {
        bail!("{url} has {index} frames: there is no start frame {}", args.start_frame);
    }
    let totals = std::mem::take(&mut track.totals);
    if let Some(film) = track.film {
        film.finish()?;
    }
    if damaged > 1 {
        tracing::warn!("{damaged} damaged pictures in total");
    }
    let figures = totals.into_figures(args.tracker.as_str(), damaged, decode_times);
    print_figures(args, &figures)?;
    if figures.is_mostly_lost() {
        tracing::warn!(
            "the boat was lost for most of the video: check the selection (the box around the whole boat, on frame {})",
            args.start_frame
        );
    }
    match failure {
        Some(error) => Err(error.context(format!("the end came after {index} frames, whose track was kept"))),
        None => Ok(ExitCode::SUCCESS),
    }
}

/// How far the track came.
struct Followed {
    /// The frames that were read.
    frames: u64,
    /// The pictures among them that were damaged.
    damaged: u64,
    /// CPU time of the decoder for each frame.
    decode_times: Vec<Duration>,
    /// Why the video was not read to its end.
    failure: Option<anyhow::Error>,
}

/// Tracks from the start frame on, until the video ends or cannot be read any more.
fn follow(
    args: &TrackArgs,
    selection: PixelBox,
    frames: &mut VideoFrames,
    track: &mut TrackWriter,
) -> Result<Followed> {
    let progress = progress_bar(frames);
    let mut decode_times = Vec::new();
    let (mut index, mut damaged) = (0_u64, 0_u64);
    let stop = flag_of_signals()?;
    let failure = loop {
        if stop.load(Ordering::Relaxed) {
            break Some(anyhow!("interrupted"));
        }
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
            Err(error) => break Some(error.into()),
        };
        decode_times.push(cpu_time().saturating_sub(before));
        if index >= args.start_frame {
            track.add(args, selection, index, &frame)?;
        }
        index += 1;
        progress.inc(1);
    };
    progress.finish_and_clear();
    Ok(Followed { frames: index, damaged, decode_times, failure })
}

/// Prints the figures of the track, as JSON or as a summary.
fn print_figures(args: &TrackArgs, figures: &TrackFigures) -> Result<()> {
    if args.json {
        writeln!(stdout(), "{}", serde_json::to_string_pretty(&figures)?)?;
    } else {
        let files = [&args.output, &args.overlay].into_iter().flatten();
        let summary = figures.summary(&files.map(|file| file.display().to_string()).collect::<Vec<_>>());
        match &args.output {
            Some(_) => writeln!(stdout(), "{summary}")?,
            // The track itself is on stdout.
            None => tracing::info!("{summary}"),
        }
    }
    Ok(())
}

/// The box that the operator draws on a page, in the start frame.
fn drawn_selection(args: &TrackArgs, url: &VideoUrl) -> Result<PixelBox> {
    if args.listen.is_none() && !has_display() {
        return Err(UsageError(format!(
            "no selection: give --select X,Y,W,H, the box around the boat in frame {} (`barrelman snapshot {} --frame {} \
             --output frame.png` shows it with coordinates), or --listen 127.0.0.1:8480 to draw the box in a browser",
            args.start_frame, args.video, args.start_frame
        ))
        .into());
    }
    let address = ConsoleAddress { listen: args.listen, ..ConsoleAddress::default() };
    let settings = ConsoleSettings::without_tokens_on_loopback(address, KeptTokens::default())?;
    let opens_browser = args.listen.is_none();
    draw_selection(url, args.start_frame, settings, AfterPicking::Nothing, opens_browser)
}

/// CPU time of all threads of the program. While the tracker runs, no other thread does, so a difference is
/// the tracker's.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // CPU time counts from zero: neither part is negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

fn progress_bar(frames: &VideoFrames) -> ProgressBar {
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
    /// Whether the header is written. The header comes with the first row, so that a refused selection leaves
    /// no file behind.
    has_rows: bool,
    film: Option<Film>,
    explanation: Option<Explanation>,
    totals: TrackTotals,
}

impl TrackWriter {
    fn add(&mut self, args: &TrackArgs, selection: PixelBox, index: u64, frame: &VideoFrame) -> Result<()> {
        let before = cpu_time();
        let is_selected_here = index == args.start_frame;
        let track = if is_selected_here {
            let report = self.tracker.select(frame, selection)?;
            for warning in selection_warnings(selection, &report, frame.picture.size()) {
                tracing::warn!("{warning}");
            }
            Track::Tracking(report.localisation)
        } else {
            self.tracker.track(frame, None)
        };
        self.totals.add(&track, (!is_selected_here).then(|| cpu_time().saturating_sub(before)));
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
