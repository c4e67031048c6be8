//! Writes an annotated video: frames with their scenes drawn on them.
//!
//! The first frame sets the size. A frame of another size, as after a change of the stream's resolution, is
//! fitted into it.

use std::path::PathBuf;

use anyhow::{Context, Result};
use barrelman_control::Region;
use barrelman_pilot::Outcome;
use barrelman_vision::Explanation;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{Picture, PictureSize, Timestamp, Track, VehicleRates, VideoFrame};

use crate::fitted::fitted;
use crate::{Overlay, Scene};
use barrelman_host::output::OutputFile;
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::writer::Mp4Writer;

/// Frames per second that the encoder expects. The times in the file are those of the frames.
const NOMINAL_FPS: f64 = 30.0;

/// Writes a film.
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
    /// A film in `file`, with a region of these shares of the picture. Nothing is written before the first
    /// frame.
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
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_scene(&mut self, frame: &VideoFrame, scene: &Scene<'_>) -> Result<()> {
        let size = frame.picture.size();
        if let Some(file) = self.file.take() {
            let settings = EncoderSettings::for_pictures(size, NOMINAL_FPS);
            self.writer = Some((Mp4Writer::new(file, &self.path, settings), size, frame.capture.at));
        }
        let Some((writer, first_size, start)) = &mut self.writer else { return Ok(()) };
        let picture = self.picture.get_or_insert_with(|| Picture::black(size, frame.picture.colour()));
        self.overlay.draw(frame, scene, picture);
        let at = Timestamp::ZERO.plus(frame.capture.at.since(*start));
        if *first_size == size {
            writer.write_picture(picture, at)?;
        } else {
            writer.write_picture(&fitted(picture, *first_size), at)?;
        }
        Ok(())
    }

    /// Adds a frame with the outcome of its step.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_outcome(&mut self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates) -> Result<()> {
        let Some(scene) = Scene::from_outcome(outcome) else { return Ok(()) };
        self.add_scene(frame, &Scene { rates: Some(rates), ..scene })
    }

    /// Adds a frame with the track of a tracker, without a pilot.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_track(
        &mut self,
        frame: &VideoFrame,
        track: &Track,
        explanation: Option<&Explanation>,
    ) -> Result<()> {
        let region = Region::from_shares(self.shares, frame.picture.size());
        self.add_scene(frame, &Scene { explanation, ..Scene::from_track(track, region) })
    }

    /// Finishes the film.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<()> {
        match self.writer {
            Some((writer, ..)) => writer.finish().with_context(|| format!("{}", self.path.display())),
            None => Ok(()),
        }
    }
}
