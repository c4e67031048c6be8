//! An annotated video on disk: frames with what was seen and done drawn on them.
//!
//! The first frame sets the size; frames of another size, as after a change of the stream's resolution, end the
//! film with an error that says so.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use barrelman_control::Region;
use barrelman_pilot::Outcome;
use barrelman_vision::Explanation;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{Picture, PictureSize, Timestamp, Track, VehicleRates, VideoFrame};

use crate::{Overlay, Scene};
use barrelman_host::output::OutputFile;
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::writer::Mp4Writer;

/// Frames per second that the encoder plans for; the times in the file are the frames' own.
const NOMINAL_FPS: f64 = 30.0;

/// A film that is being written.
pub struct Film {
    path: PathBuf,
    /// The file, until the first frame.
    file: Option<OutputFile>,
    writer: Option<(Mp4Writer<OutputFile>, PictureSize, Timestamp)>,
    picture: Option<Picture>,
    overlay: Overlay,
    shares: RegionShares,
}

impl Film {
    /// A film in `file`, with the region that takes up these shares of the picture. Without a frame nothing is
    /// written.
    pub fn new(file: OutputFile, shares: RegionShares) -> Self {
        Self {
            path: file.path().to_owned(),
            file: Some(file),
            writer: None,
            picture: None,
            overlay: Overlay::new(),
            shares,
        }
    }

    /// Adds a frame with a scene drawn on it.
    fn add(&mut self, frame: &VideoFrame, scene: &Scene<'_>) -> Result<()> {
        let size = frame.picture.size();
        if let Some(file) = self.file.take() {
            let settings = EncoderSettings::for_pictures(size, NOMINAL_FPS);
            self.writer = Some((Mp4Writer::new(file, &self.path, settings), size, frame.capture.at));
        }
        let Some((writer, first_size, start)) = &mut self.writer else { return Ok(()) };
        if *first_size != size {
            bail!(
                "{}: the video's size changed from {first_size} to {size}, which one film cannot hold",
                self.path.display()
            );
        }
        let picture = self.picture.get_or_insert_with(|| Picture::black(size, frame.picture.colour()));
        self.overlay.draw(frame, scene, picture);
        writer.write_picture(picture, Timestamp::ZERO.plus(frame.capture.at.since(*start)))?;
        Ok(())
    }

    /// Adds a frame with the outcome of its step.
    ///
    /// # Errors
    /// If the frame has another size than the first, or the file cannot be written.
    pub fn add_outcome(&mut self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates) -> Result<()> {
        let Some(scene) = Scene::from_outcome(outcome) else { return Ok(()) };
        self.add(frame, &Scene { rates: Some(rates), ..scene })
    }

    /// Adds a frame with what a tracker alone made of it.
    ///
    /// # Errors
    /// If the frame has another size than the first, or the file cannot be written.
    pub fn add_track(&mut self, frame: &VideoFrame, track: &Track, why: Option<&Explanation>) -> Result<()> {
        let region = Region::from_shares(self.shares, frame.picture.size());
        self.add(frame, &Scene { explanation: why, ..Scene::from_track(track, region) })
    }

    /// Ends the film.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self) -> Result<()> {
        match self.writer {
            Some((writer, ..)) => writer.finish().with_context(|| format!("{}", self.path.display())),
            None => Ok(()),
        }
    }
}
