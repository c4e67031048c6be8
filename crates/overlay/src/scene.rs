//! The state of the program at one video frame.

use barrelman_control::{Percept, Region};
use barrelman_pilot::{Advice, Mode, Outcome};
use barrelman_vision::Explanation;
use barrelman_vocab::{CameraCommand, Track, VehicleRates};

/// The content of an overlay. Values of `None` are not shown.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The track after this frame.
    pub track: &'a Track,
    /// The region, in pixels of the frame.
    pub region: Region,
    /// The percept; `None`: computed from the track and the region.
    pub percept: Option<Percept>,
    /// The law's advice, shown as a dashed arrow while the camera rests.
    pub advice: Option<Advice>,
    /// The command in force (pan > 0 right, tilt > 0 up): the direction of the arrows.
    pub command: CameraCommand,
    /// The rates sent, in the vehicle's signs: the numbers at the arrows and in the strip.
    pub rates: Option<VehicleRates>,
    /// The pilot's mode; `None` without a pilot.
    pub mode: Option<Mode>,
    /// The time of day, shown instead of the frame's time.
    pub time_of_day: Option<&'a str>,
    /// State of the link to the vehicle, a short text.
    pub link: Option<&'a str>,
    /// The tracker's explanation.
    pub explanation: Option<&'a Explanation>,
}

impl<'a> Scene<'a> {
    /// A scene without a pilot: a track, and the region for P.
    pub fn from_track(track: &'a Track, region: Region) -> Self {
        Self {
            track,
            region,
            percept: None,
            advice: None,
            command: CameraCommand::REST,
            rates: None,
            mode: None,
            time_of_day: None,
            link: None,
            explanation: None,
        }
    }

    /// The scene of a pilot's step. The caller adds rates, link and explanation:
    /// `Scene { rates: Some(rates), ..scene }`. `None` before the pilot's first video frame or localisation,
    /// which determines the region.
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
