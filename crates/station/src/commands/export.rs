//! `barrelman export`: converts a recording to one CSV file a channel, a CSV file of the trial, and an MP4 of
//! the video.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write as _, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use barrelman_trial::csv_row::quoted;
use barrelman_trial::logs::exported;
use barrelman_trial::logs::recorded::RowSelector;
use barrelman_trial::records::table::read_rows;
use barrelman_trial::records::{Entry, ReadError, RecordedOutcome, RecordingReader, RecordingStart};
use barrelman_vocab::{PictureSize, Timestamp, VideoNumber, Videos};

use super::annotated_film::{self, FilmPictures};
use super::channel_tables::ChannelTables;
use super::exported_video::VideoFile;
use super::map_tracks::{MapFormat, Tracks};
use super::report;
use crate::cli::{ExportArgs, RegionArgs, ReportArgs};
use barrelman_experiments::campaign::recorded_trial;
use barrelman_host::input;
use barrelman_host::output::OutputFile;

/// The name of the trial's table, without its extension.
const TRIAL: &str = "trial";
/// The page of the report.
const REPORT: &str = "report.html";
/// The film with the annotations.
const ANNOTATED: &str = "annotated.mp4";
/// Its name until it is whole.
const BEGUN: &str = "annotated.mp4.begun";

/// Runs the command.
///
/// # Errors
/// If the recording cannot be read or an output not be written. Of a truncated recording everything before
/// the cut is exported.
pub fn run(args: &ExportArgs) -> Result<ExitCode> {
    let context = || format!("{} cannot be exported", args.recording.display());
    // Opened before the folder is made: a wrong path leaves no empty folder behind.
    input::open(&args.recording)?;
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("the folder {} cannot be created", args.output.display()))?;
    // Opened before any table: an export that finds the files of another export writes nothing.
    let trial = OutputFile::open(&args.output.join(format!("{TRIAL}.csv")), args.force)?;
    let open = |video: VideoNumber| OutputFile::open(&args.output.join(video_name(video)), args.force);
    let videos = videos_of(&args.recording)?.try_map(|number, ()| open(number))?;
    let annotated = args.annotated.then(|| FilmFile::open(args)).transpose()?;
    let cut_channels = export_channels(args).with_context(context)?;
    let ExportedTrial { is_cut: cut_trial, written, damaged, start, tracks } =
        export_trial(args, trial, videos).with_context(context)?;
    let has_video = !written.is_empty();
    writeln!(
        stdout(),
        "{} holds trial.csv, one CSV per channel{}",
        args.output.display(),
        written.iter().map(|video| format!(", {}", video_name(*video))).collect::<String>()
    )?;
    if damaged > 0 {
        writeln!(stdout(), "pictures left out of the video, as they are damaged: {damaged}")?;
    }
    if !has_video
        && let Some(reason) = start.as_deref().and_then(|start| reason_without_video(start, &args.recording))
    {
        writeln!(stdout(), "{reason}")?;
    }
    if args.report {
        write_report(args);
    }
    write_tracks(args, &tracks).with_context(context)?;
    if let Some(film) = annotated {
        let FilmPictures { drawn, left_out } = film.write(&args.recording).with_context(context)?;
        writeln!(stdout(), "{ANNOTATED}: {drawn} pictures")?;
        if let Some((count, first)) = left_out {
            writeln!(stdout(), "pictures left out of {ANNOTATED}: {count} ({first})")?;
        }
    }
    if cut_channels || cut_trial {
        tracing::error!("the recording is cut off: everything before the cut was exported");
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

/// The film with the annotations, which gets its name when it is whole.
struct FilmFile {
    file: OutputFile,
    begun: PathBuf,
    whole: PathBuf,
}

impl FilmFile {
    /// Opens the film. What an export that was killed has left is overwritten.
    fn open(args: &ExportArgs) -> Result<Self> {
        let whole = args.output.join(ANNOTATED);
        if !args.force && whole.symlink_metadata().is_ok() {
            bail!("{} exists already: choose another name, or overwrite it with --force", whole.display());
        }
        let begun = args.output.join(BEGUN);
        Ok(Self { file: OutputFile::open(&begun, true)?, begun, whole })
    }

    /// Writes the film of a recording. Without a picture there is no film.
    fn write(self, recording: &Path) -> Result<FilmPictures> {
        let Self { file, begun, whole } = self;
        let pictures = annotated_film::write(recording, file);
        if matches!(pictures, Ok(FilmPictures { drawn: 1.., .. })) {
            std::fs::rename(&begun, &whole)
                .with_context(|| format!("{} cannot be written", whole.display()))?;
        } else {
            let _ = std::fs::remove_file(&begun);
        }
        pictures
    }
}

/// Writes the page of `barrelman report`. A recording without a localisation has none.
fn write_report(args: &ExportArgs) {
    let page = ReportArgs {
        logs: vec![args.recording.clone()],
        output: args.output.join(REPORT),
        svg: None,
        arena: None,
        region: RegionArgs::default(),
        force: args.force,
    };
    if let Err(error) = report::run(&page) {
        tracing::warn!("no {REPORT}: {error:#}");
        let _ = std::fs::remove_file(&page.output);
    }
}

/// Writes the tracks for maps that are asked for.
fn write_tracks(args: &ExportArgs, tracks: &Tracks) -> Result<()> {
    let asked = [(args.geojson, MapFormat::Geojson), (args.kml, MapFormat::Kml), (args.gpx, MapFormat::Gpx)];
    let formats: Vec<_> = asked.iter().filter(|(is_asked, _)| *is_asked).map(|(_, format)| *format).collect();
    if formats.is_empty() {
        return Ok(());
    }
    tracks.require_some()?;
    for format in formats {
        let path = args.output.join(format.file());
        let mut file = BufWriter::new(OutputFile::open(&path, args.force)?);
        tracks.write(format, &mut file)?;
        file.flush()?;
        writeln!(stdout(), "{}: boat and marks on Earth", format.file())?;
    }
    Ok(())
}

/// Writes a CSV file for every channel. Returns whether the recording is truncated.
fn export_channels(args: &ExportArgs) -> Result<bool> {
    let mut tables = ChannelTables::new(&args.output, args.force, &[TRIAL]);
    let result =
        read_rows(BufReader::new(File::open(&args.recording)?), |row| -> Result<()> { tables.add(&row) });
    tables.finish()?;
    match result {
        Ok(()) => Ok(false),
        Err(error) if matches!(error.downcast_ref(), Some(ReadError::Truncated)) => Ok(true),
        Err(error) => Err(error),
    }
}

/// Why the recording of a simulated trial gives no video; `None` for other recordings.
fn reason_without_video(start: &RecordingStart, recording: &Path) -> Option<String> {
    let is_trial = start.trial.is_some() || start.is_simulated_trial();
    if !is_trial {
        return None;
    }
    let settings = start.trial.as_ref().and_then(|trial| recorded_trial::settings_of(trial).ok());
    if settings.is_some_and(|settings| settings.perception == "truth") {
        return Some("no video.mp4: a trial with --perception truth has no pictures".to_owned());
    }
    let film = recording.with_extension("mp4");
    let place = if film.exists() { "is" } else { "was written as" };
    Some(format!(
        "no video.mp4: the recording of a simulated trial holds no pictures. Its film {place} {};\n\
         `barrelman replay` renders the pictures again",
        film.display()
    ))
}

/// The videos of a recording, as its start announces them; one where it has none.
fn videos_of(recording: &Path) -> Result<Videos<()>> {
    let first = RecordingReader::new(BufReader::new(File::open(recording)?)).next();
    Ok(match first {
        Some(Ok(Entry::Start(start))) => start.videos.map(|_, _| ()),
        _ => Videos::one(()),
    })
}

const fn video_name(video: VideoNumber) -> &'static str {
    match video {
        VideoNumber::First => "video.mp4",
        VideoNumber::Second => "video2.mp4",
    }
}

/// What an export of the trial found.
struct ExportedTrial {
    is_cut: bool,
    /// The videos that were written.
    written: Vec<VideoNumber>,
    /// Pictures that could not be decoded.
    damaged: u64,
    start: Option<Box<RecordingStart>>,
    tracks: Tracks,
}

/// Writes the trial's CSV file and the video.
fn export_trial(args: &ExportArgs, trial: OutputFile, videos: Videos<OutputFile>) -> Result<ExportedTrial> {
    let mut trial = TrialFile::begin(trial)?;
    let mut videos = videos.map(|_, file| VideoFile::new(file));
    let (mut cut, mut start, mut tracks) = (false, None, Tracks::default());
    for entry in RecordingReader::new(BufReader::new(File::open(&args.recording)?)) {
        match entry {
            Ok(Entry::Start(found)) => {
                tracks.begin(&found);
                start = Some(Box::new(found));
            }
            Ok(Entry::Outcome(outcome)) => {
                trial.add(&outcome)?;
                tracks.add(&outcome);
            }
            Ok(Entry::Unit(number, unit)) => {
                videos.get_mut(number).map_or(Ok(()), |video| video.add(&unit))?
            }
            Ok(Entry::Input { .. } | Entry::Truth(_) | Entry::Note { .. }) => {}
            Err(ReadError::Truncated) => cut = true,
            Err(error) => return Err(error.into()),
        }
    }
    trial.file.flush()?;
    let damaged = videos.iter().map(|(_, video)| video.damaged).sum();
    let mut written = Vec::new();
    let finished = videos.try_map(|number, video| video.finish().map(|is_written| (number, is_written)))?;
    written.extend(finished.iter().filter(|(_, (_, is_written))| *is_written).map(|(number, _)| number));
    Ok(ExportedTrial { is_cut: cut, written, damaged, start, tracks })
}

/// The trial's CSV file, which `metrics` and `law` read.
struct TrialFile {
    file: BufWriter<OutputFile>,
    rows: RowSelector,
    start: Option<Timestamp>,
    size: Option<PictureSize>,
}

impl TrialFile {
    fn begin(file: OutputFile) -> Result<Self> {
        let mut file = BufWriter::new(file);
        writeln!(file, "{}", exported::HEADER)?;
        Ok(Self { file, rows: RowSelector::default(), start: None, size: None })
    }

    fn add(&mut self, outcome: &RecordedOutcome) -> Result<()> {
        if let Some(seen) = outcome.track.localisation() {
            self.size = Some(seen.picture);
        }
        // The rows are those of the localisations, also of a simulated trial in pixels, whose truth is not
        // exported.
        let is_accepted = self.rows.accepts(outcome, false);
        let Some(size) = self.size.filter(|_| is_accepted) else { return Ok(()) };
        let start = *self.start.get_or_insert(outcome.at);
        write!(self.file, "{},", outcome.at.since(start).as_secs_f64())?;
        match &outcome.percept {
            Some(percept) => {
                write!(self.file, "{},{},{},", percept.position.x, percept.position.y, percept.p)?;
            }
            None => write!(self.file, ",,,")?,
        }
        let sent = outcome.rates.in_the_senses_of(outcome.command);
        writeln!(
            self.file,
            "{},{},{},{},{}",
            sent.pan.radians_per_second(),
            sent.tilt.radians_per_second(),
            quoted(&outcome.mode.to_string()),
            size.width,
            size.height
        )?;
        Ok(())
    }
}
