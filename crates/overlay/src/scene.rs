//! What is known at one video frame.

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Advice, Mode, Outcome};
use barrelman_vision::Explanation;
use barrelman_vocab::{CameraCommand, Track, VehicleRates};

/// What an overlay is to show. Whatever is not known is left out of the picture.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The track after this frame.
    pub track: &'a Track,
    /// The region that the target may roam in, in pixels of the frame.
    pub region: Region,
    /// What the localisation means to the law. Where it is absent, it is taken from the track and the region.
    pub percept: Option<Percept>,
    /// What the law asks for. Shown as a dashed arrow where the camera rests all the same.
    pub advice: Option<Advice>,
    /// What is in force (pan > 0 right, tilt > 0 up): the direction of the camera's arrow.
    pub command: CameraCommand,
    /// The same in the vehicle's own signs, as sent: the numbers at the arrow and in the strip.
    pub rates: Option<VehicleRates>,
    /// Whether the camera may move; absent where nothing is piloted.
    pub mode: Option<Mode>,
    /// State of the link to the vehicle, in a few words.
    pub link: Option<&'a str>,
    /// What the tracker's answer rests on.
    pub explanation: Option<&'a Explanation>,
}

impl<'a> Scene<'a> {
    /// A scene without a pilot: a track and the region that P is counted in.
    pub fn from_track(track: &'a Track, region: Region) -> Self {
        Self {
            track,
            region,
            percept: None,
            advice: None,
            command: CameraCommand::REST,
            rates: None,
            mode: None,
            link: None,
            explanation: None,
        }
    }

    /// What came of a pilot's step. The rates as sent, the link and the explanation are the caller's to add:
    /// `Scene { rates: Some(rates), ..scene }`. `None` before the pilot's first observation, which gives the region.
    pub fn from_outcome(outcome: &'a Outcome) -> Option<Self> {
        Some(Self {
            percept: outcome.percept,
            advice: outcome.advice,
            command: outcome.command,
            mode: Some(outcome.mode),
            ..Self::from_track(&outcome.track, outcome.region?)
        })
    }
}
