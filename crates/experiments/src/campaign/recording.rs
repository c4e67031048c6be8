//! Stores a simulated trial: its recording, and for a trial on pictures its annotated video.

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use barrelman_pilot::{CommandPath, Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::records::{
    Entry, RecordedInput, RecordedOutcome, RecordedTruth, RecordedVideo, RecordingStart, RecordingWriter,
    SimulatedTrial,
};
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{EncodedUnit, Note, Timestamp, VehicleProfile, VehicleRates, VideoNumber};

use barrelman_host::output::OutputFile;
use barrelman_overlay::film::Film;

/// Simulated time between two times at which the recording of a drive is written out.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// Settings of the recordings of a campaign.
#[derive(Debug, Clone)]
pub struct TrialRecording {
    /// The folder of the recordings.
    pub folder: PathBuf,
    /// Whether existing files are overwritten.
    pub force: bool,
    /// The effective configuration (TOML), the first record of each recording.
    pub configuration: String,
}

/// The simulated run that a recording shows.
#[derive(Debug, Clone)]
pub struct RecordedRun {
    /// Address of the simulated world.
    pub video: String,
    /// What it takes to run a trial again; `None` for a drive, whose recording holds its video.
    pub trial: Option<SimulatedTrial>,
}

/// Writes the recording and the film of a trial.
pub struct TrialRecorder {
    path: PathBuf,
    writer: RecordingWriter<BufWriter<OutputFile>>,
    /// The annotated video, if any.
    film: Option<Film>,
    /// When the recording of a drive is written out next, so that a killed program leaves what was driven so
    /// far. `None`: at the end only, as a trial is run again.
    flush_at: Option<Timestamp>,
    step: u64,
    /// The first error; nothing is written after it.
    error: Option<anyhow::Error>,
}

impl TrialRecorder {
    /// Begins `NAME.mcap` in the folder, and with the first picture `NAME.mp4`.
    ///
    /// # Errors
    /// A file exists and may not be overwritten, or cannot be written.
    pub fn begin(
        recording: &TrialRecording,
        name: &str,
        run: RecordedRun,
        profile: &VehicleProfile,
    ) -> Result<Self> {
        let TrialRecording { folder, force, configuration } = recording;
        let path = folder.join(format!("{name}.mcap"));
        let film = folder.join(format!("{name}.mp4"));
        let film = Film::new(OutputFile::open(&film, *force)?, profile.region);
        let file = OutputFile::open(&path, *force)?;
        let configuration = configuration.clone();
        Ok(Self { film: Some(film), ..Self::without_film(file, configuration, run, profile)? })
    }

    /// Begins a recording without an annotated video.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn without_film(
        file: OutputFile,
        configuration: String,
        run: RecordedRun,
        profile: &VehicleProfile,
    ) -> Result<Self> {
        let path = file.path().to_owned();
        // The times of a clock would make files of the same seed differ.
        let start = RecordingStart {
            program: barrelman_host::program::identity().to_owned(),
            monotonic_ns: 0,
            unix_ns: 0,
            configuration,
            videos: RecordedVideo::only(run.video, false),
            link: "sim:".to_owned(),
            command_path: CommandPath::Simulated,
            trial: run.trial,
        };
        let flush_at = start.trial.is_none().then_some(Timestamp::ZERO);
        let writer = RecordingWriter::begin(BufWriter::new(file), &start, profile)
            .with_context(|| cannot_be_written(&path))?;
        Ok(Self { path, writer, film: None, flush_at, step: 0, error: None })
    }

    /// Finishes both files.
    ///
    /// # Errors
    /// The first error of any write.
    pub fn finish(self) -> Result<()> {
        if let Some(error) = self.error {
            return Err(error);
        }
        self.writer.finish().with_context(|| cannot_be_written(&self.path))?;
        self.film.map_or(Ok(()), Film::finish)
    }

    /// Adds an encoded unit, before the step of its video frame.
    pub fn add_unit(&mut self, unit: EncodedUnit) {
        if self.error.is_none() {
            self.error = self.write(&Entry::Unit(VideoNumber::First, unit)).err();
        }
    }

    /// Adds a moment that somebody marked.
    pub fn add_note(&mut self, at: Timestamp, note: Note) {
        if self.error.is_none() {
            self.error = self.write(&Entry::Note { at, note }).err();
        }
    }

    fn write(&mut self, entry: &Entry) -> Result<()> {
        self.writer.write(entry).with_context(|| cannot_be_written(&self.path))
    }

    fn write_step(
        &mut self,
        now: Timestamp,
        input: &Input<'_>,
        outcome: &Outcome,
        rates: VehicleRates,
    ) -> Result<()> {
        let step = self.step;
        self.step += 1;
        self.write(&Entry::Input { step, now, input: RecordedInput::from_input(input) })?;
        self.write(&Entry::Outcome(RecordedOutcome::new(step, outcome, rates)))?;
        if let (Input::Frame(frame), Some(film)) = (input, &mut self.film) {
            film.add_outcome(frame, outcome, rates)?;
        }
        if self.flush_at.is_some_and(|at| at <= now) {
            self.flush_at = Some(now.plus(FLUSH_INTERVAL));
            self.writer.flush().with_context(|| cannot_be_written(&self.path))?;
        }
        Ok(())
    }
}

fn cannot_be_written(path: &Path) -> String {
    format!("{} cannot be written", path.display())
}

impl StepObserver for TrialRecorder {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        if self.error.is_none() {
            self.error = self.write_step(now, input, outcome, rates).err();
        }
    }

    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        if self.error.is_none() {
            self.error = self.write(&Entry::Truth(RecordedTruth::new(truth, target))).err();
        }
    }
}
