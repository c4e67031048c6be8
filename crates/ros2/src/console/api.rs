//! The part of the console's API that the node reads. A test compares it with the API's own schema.

use serde::Deserialize;

/// A message of the socket.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum ServerMessage {
    /// The first message.
    Hello(Hello),
    /// The newest state.
    Snapshot(Box<Snapshot>),
    /// The answer to a request.
    Answer(Answer),
    /// Who controls.
    Control(Control),
    /// The answer to `ping`.
    Pong(Pong),
    /// A message that the node does not need.
    #[serde(other)]
    Other,
}

/// What does not change while the connection is open.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Hello {
    /// Number of this client.
    pub client: u64,
    /// The vehicle profile.
    pub vehicle: String,
}

/// Who controls.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Control {
    /// Number of who is in control; `None`: nobody.
    pub holder: Option<u64>,
}

/// The answer to `ping`.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Pong {
    /// The time of the ping, as it was sent.
    pub sent_ms: f64,
    /// The program's time.
    pub now_ns: u64,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Answer {
    /// Number of the request.
    pub id: u64,
    /// The answer.
    pub answer: AnswerKind,
    /// The reason, in words.
    pub reason: Option<String>,
}

/// What became of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AnswerKind {
    /// The request is in force.
    Accepted,
    /// The request has no effect.
    Refused,
    /// A later request took its place.
    Superseded,
}

/// The state after the newest step.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Snapshot {
    /// Time of the newest step.
    pub at_ns: u64,
    /// The pilot's mode.
    pub mode: Mode,
    /// The track.
    pub track: Track,
    /// The command in force.
    pub command: Rates,
    /// The video.
    pub video: Video,
    /// Where the followed boat is.
    pub boat: Option<Boat>,
    /// The boat that is commanded, with the marks.
    pub vessel: Option<Vessel>,
    /// Whether latitude and longitude can be known.
    pub earth: String,
    /// The link to the vehicle.
    pub link: Link,
    /// Alarms in force, by their keys.
    pub alarms: Vec<String>,
}

/// The pilot's mode.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Mode {
    /// The mode's key.
    pub name: String,
    /// The cause's key.
    pub cause: Option<String>,
    /// Whether the pilot is engaged.
    pub engaged: bool,
}

/// The track.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Track {
    /// `unseeded`, `tracking`, `coasting` or `lost`.
    pub state: String,
    /// Whether a selection waits for its confirmation.
    pub confirming: bool,
    /// Whether a detector contradicts that what was found again is the boat.
    pub doubted: bool,
    /// Time of capture of the localisation.
    pub captured_ns: Option<u64>,
    /// Left, top, width, height, pixels.
    #[serde(rename = "box")]
    pub bounds: Option<[f64; 4]>,
    /// The tracker's confidence, 0 to 1.
    pub confidence: Option<f64>,
    /// For how long the track has been lost, seconds.
    pub lost_s: Option<f64>,
}

/// A rate of each camera axis, rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Rates {
    /// Positive to the right.
    pub pan: f64,
    /// Positive upwards.
    pub tilt: f64,
}

/// The video.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Video {
    /// `connecting`, `up`, `lost` or `ended`.
    pub state: String,
    /// Why the video was lost, or what is wrong with it.
    pub reason: Option<String>,
    /// Time of capture of the newest video frame that the pilot processed.
    pub captured_ns: Option<u64>,
    /// Age of that frame when the pilot had processed it, milliseconds.
    pub age_ms: Option<f64>,
    /// Frames a second.
    pub fps: f64,
}

/// Where the followed boat is.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Boat {
    /// Standard deviation of the distance, metres.
    pub std_dev_m: f64,
    /// Where the boat is on Earth.
    pub on_earth: Option<Place>,
}

/// A place on Earth (WGS 84).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Place {
    /// Degrees, positive to the north.
    pub latitude_deg: f64,
    /// Degrees, positive to the east.
    pub longitude_deg: f64,
}

/// The boat that is commanded.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Vessel {
    /// The marks, oldest first.
    pub marks: Vec<Mark>,
}

/// A mark.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Mark {
    /// Number of the mark.
    pub id: u32,
    /// The kind's key.
    pub kind: String,
    /// Where the mark is on Earth.
    pub on_earth: Option<Place>,
    /// Standard deviation of the place, metres.
    pub std_dev_m: Option<f64>,
}

/// The link to the vehicle.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Link {
    /// The state's key.
    pub state: String,
    /// Whether the vehicle accepts commands from the program.
    pub in_control: Option<bool>,
    /// Battery voltage, volts.
    pub battery_v: Option<f64>,
}

#[cfg(test)]
mod tests;
