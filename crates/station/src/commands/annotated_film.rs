//! The film of a recording with box, region, mode and the time of day drawn into the pictures.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use barrelman_control::Region;
use barrelman_host::output::OutputFile;
use barrelman_overlay::Scene;
use barrelman_overlay::film::Film;
use barrelman_trial::records::{
    Entry, ReadError, RecordedInput, RecordedOutcome, RecordingReader, RecordingStart,
};
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{Timestamp, VideoFrame};
use jiff::tz::TimeZone;

use super::replay::MAX_QUEUED_BYTES;
use super::replayed_video::ReplayedVideo;
use super::stored_video::OtherPicture;
use crate::config::{self, Configuration};

/// A film that lacks more is none: of another decoder, say, each picture differs.
const LEAST_DRAWN_PER_LEFT_OUT: u64 = 10;

/// What is read of a recording before its first picture.
struct Begun {
    video: ReplayedVideo,
    shares: RegionShares,
    /// Unix time of the recording's clock; `None`: simulated time.
    unix_start_ns: Option<u64>,
}

/// The pictures of a film.
#[derive(Debug, Default)]
pub(super) struct FilmPictures {
    pub(super) drawn: u64,
    /// How many pictures of the run are not in the film, as they do not decode to the same again, and why the
    /// first of them is not.
    pub(super) left_out: Option<(u64, String)>,
}

/// Writes the film of a recording, up to where it is cut off.
///
/// # Errors
/// If the recording holds no start, too many of its pictures cannot be decoded again, or the file cannot be
/// written.
pub(super) fn write(recording: &Path, file: OutputFile) -> Result<FilmPictures> {
    let mut entries = RecordingReader::new(BufReader::new(File::open(recording)?));
    let Some(Entry::Start(start)) = entries.next().transpose()? else {
        bail!("it does not begin with a start message: it is not a recording of this program");
    };
    let mut begun = Begun::new(&start)?;
    let mut film = Film::new(file, begun.shares);
    let (mut pictures, mut pending) = (FilmPictures::default(), None);
    for entry in entries {
        match entry {
            Ok(Entry::Unit(video, unit)) => begun.video.add(video, unit)?,
            Ok(Entry::Input { step, input: RecordedInput::Frame(fingerprint), .. }) => {
                match begun.video.frame(&fingerprint) {
                    Ok(frame) => pending = Some((step, frame)),
                    Err(error) if error.is::<OtherPicture>() => pictures.leave_out(&error),
                    Err(error) => return Err(error),
                }
            }
            Ok(Entry::Outcome(outcome)) => {
                begun.video.command(&outcome);
                if let Some((_, frame)) = pending.take_if(|(step, _)| *step == outcome.step) {
                    begun.draw(&mut film, &frame, &outcome)?;
                    pictures.drawn += 1;
                }
            }
            Ok(Entry::Input { .. } | Entry::Truth(_) | Entry::Note { .. } | Entry::Start(_)) => {}
            Err(ReadError::Truncated) => break,
            Err(error) => return Err(error.into()),
        }
    }
    if let FilmPictures { drawn, left_out: Some((count, reason)) } = &pictures
        && *count * LEAST_DRAWN_PER_LEFT_OUT > *drawn
    {
        bail!("{count} of {} pictures are missing: {reason}", count + drawn);
    }
    film.finish()?;
    Ok(pictures)
}

impl FilmPictures {
    fn leave_out(&mut self, error: &anyhow::Error) {
        let (count, _) = self.left_out.get_or_insert_with(|| (0, format!("{error:#}")));
        *count += 1;
    }
}

impl Begun {
    fn new(start: &RecordingStart) -> Result<Self> {
        let configuration = Configuration::resolve_recorded(&config::parse(&start.configuration)?)
            .context("the recorded configuration")?;
        Ok(Self {
            video: ReplayedVideo::new(start, MAX_QUEUED_BYTES),
            shares: configuration.profile.region,
            unix_start_ns: (start.unix_ns > 0).then_some(start.unix_ns),
        })
    }

    fn draw(&self, film: &mut Film, frame: &VideoFrame, outcome: &RecordedOutcome) -> Result<()> {
        let time_of_day = self.time_of_day(frame.capture.at);
        let region = Region::from_shares(self.shares, frame.picture.size());
        let scene = Scene {
            percept: outcome.percept,
            advice: outcome.advice,
            command: outcome.command,
            rates: Some(outcome.rates),
            mode: Some(outcome.mode),
            time_of_day: time_of_day.as_deref(),
            ..Scene::from_track(&outcome.track, region)
        };
        film.add_scene(frame, &scene)
    }

    fn time_of_day(&self, at: Timestamp) -> Option<String> {
        let unix_ns = i128::from(self.unix_start_ns?) + i128::from(at.as_nanos());
        let at = jiff::Timestamp::from_nanosecond(unix_ns).ok()?.to_zoned(TimeZone::system());
        Some(at.strftime("%H:%M:%S%.1f").to_string())
    }
}
