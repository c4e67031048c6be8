//! The video frames of a replay: decoded from the recording, or rendered again where the recording holds
//! none.

use anyhow::{Context, Result, anyhow, bail};
use barrelman_experiments::campaign::recorded_trial;
use barrelman_trial::campaign::WorldReplay;
use barrelman_trial::records::{
    FrameFingerprint, RecordedOutcome, RecordedVessel, RecordingStart, SimulatedTrial,
};
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::{EncodedUnit, Timestamp, VehicleRates, VesselOrder, VideoFrame, VideoNumber, Videos};

use super::stored_video::StoredVideo;

/// Where a replay takes its video frames from.
pub struct ReplayedVideo {
    stored: Videos<StoredVideo>,
    /// The video of the newest frame.
    tracked: VideoNumber,
    /// Whether the recording holds video.
    has_units: bool,
    /// The recorded simulated trial, if the recording says which.
    trial: Option<SimulatedTrial>,
    /// Whether the recording is of a simulated trial, as far as its address tells.
    is_simulated: bool,
    world: Option<Box<WorldReplay<'static>>>,
    /// The recorded commands before the first frame.
    early_commands: Vec<(Timestamp, VehicleRates, VesselOrder)>,
}

impl ReplayedVideo {
    /// The video of a recording with this start. At most `max_queued_bytes` of encoded video are queued.
    pub fn new(start: &RecordingStart, max_queued_bytes: usize) -> Self {
        Self {
            stored: start.videos.as_ref().map(|_, video| {
                let mode = if video.is_live { DecodeMode::Live } else { DecodeMode::File };
                StoredVideo::new(mode, max_queued_bytes)
            }),
            tracked: VideoNumber::First,
            has_units: false,
            trial: start.trial.clone(),
            is_simulated: start.is_simulated_trial(),
            world: None,
            early_commands: Vec::new(),
        }
    }

    /// Whether frames were rendered again.
    pub const fn is_rendered(&self) -> bool {
        self.world.is_some()
    }

    /// Adds the next unit of the recording.
    ///
    /// # Errors
    /// As [`StoredVideo::add`], or if the recording does not announce the video.
    pub fn add(&mut self, video: VideoNumber, unit: EncodedUnit) -> Result<()> {
        self.has_units = true;
        let is_tracked = video == self.tracked;
        let stored = self.stored_mut(video)?;
        if is_tracked {
            return stored.add(unit);
        }
        stored.add_unused(unit);
        Ok(())
    }

    fn stored_mut(&mut self, video: VideoNumber) -> Result<&mut StoredVideo> {
        let missing = || anyhow!("it has pictures of a second video that its start does not announce");
        self.stored.get_mut(video).ok_or_else(missing)
    }

    fn stored_frame(&mut self, fingerprint: &FrameFingerprint) -> Result<VideoFrame> {
        self.tracked = fingerprint.video;
        self.stored_mut(fingerprint.video)?.frame(fingerprint)
    }

    /// Adds a recorded outcome, whose command moves the camera of a world that is rendered again.
    pub fn command(&mut self, outcome: &RecordedOutcome) {
        let order = outcome.vessel.as_deref().map_or(VesselOrder::Released, RecordedVessel::order);
        match &mut self.world {
            Some(world) => world.command(outcome.at, outcome.rates, order),
            // A simulated operator selects within seconds: frames come early.
            None if self.trial.is_some() && !self.has_units => {
                self.early_commands.push((outcome.at, outcome.rates, order));
            }
            None => {}
        }
    }

    /// The frame of a fingerprint.
    ///
    /// # Errors
    /// If the recording neither holds the frame nor says how to render it, or if its picture is another than
    /// the recorded one.
    pub fn frame(&mut self, fingerprint: &FrameFingerprint) -> Result<VideoFrame> {
        if self.has_units {
            return self.stored_frame(fingerprint);
        }
        let Some(trial) = &self.trial else {
            if self.is_simulated {
                bail!(
                    "it is a simulated trial in pixels, whose recording holds no pictures, made by a program that did not \
                     store scenario and settings with it: run the trial again with `barrelman trials ... --record DIR`, or \
                     look at its film, the .mp4 beside it"
                );
            }
            return self.stored_frame(fingerprint);
        };
        if self.world.is_none() {
            let mut world =
                recorded_trial::world_of(trial).context("its pictures cannot be rendered again")?;
            for (at, rates, order) in self.early_commands.drain(..) {
                world.command(at, rates, order);
            }
            self.world = Some(Box::new(world));
        }
        let (sequence, captured) = (fingerprint.sequence, fingerprint.capture.at);
        let frame = self.world.as_mut().and_then(|world| world.frame(sequence, captured));
        let Some(mut frame) = frame else {
            bail!(
                "the world that was rendered again has no video frame {sequence}: the simulator has changed since"
            );
        };
        if FrameFingerprint::from_frame(fingerprint.video, &frame).luma_hash != fingerprint.luma_hash {
            bail!(
                "video frame {sequence} is rendered to another picture than in the recorded run: the simulator has changed since"
            );
        }
        frame.capture = fingerprint.capture;
        Ok(frame)
    }
}
