//! The state of a session after its newest step, as one immutable value.
//!
//! The loop publishes a [`Snapshot`] after each step; the page, `/metrics` and the status line read the
//! newest one. A reader never delays the loop: publishing replaces a shared pointer. What must not be missed,
//! such as refusals and changes of mode, is in the [`EventLog`].
//!
//! ```text
//! RunLoop, LiveDrive --step--> Publisher --Arc<Snapshot>--> watch channel --> page, metrics
//!                                  \------events---------> EventLog -------> page
//! ```

mod publisher;

mod alarm;
mod boat_on_water;
#[cfg(test)]
mod camera_work;
mod drive_state;
mod event_log;
mod frame_rate;
mod pose_reports;
mod step_time;
mod text_rate;
mod timing_text;
mod vehicle;

use barrelman_experiments::drill::DrillState;
use std::sync::Arc;
use std::time::Duration;

use barrelman_pilot::Outcome;
use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::vehicle_text::VehicleText;
use barrelman_vocab::{LawId, PictureSize, Timestamp, VehicleRates, VideoNumber};

pub use alarm::Alarm;
pub use barrelman_trial::camera_work::{CameraWork, WorkFigures};
pub use boat_on_water::BoatOnWater;
pub use drive_state::{DriveState, WorldState};
pub use event_log::{EventEntry, EventLog, Level};
pub use publisher::{Publisher, link_state_text};
pub use vehicle::{LinkStatus, VehiclePosition, VehicleSnapshot};

/// The newest snapshot; all readers share it.
pub type SharedSnapshot = Arc<Snapshot>;

/// The state of a session after its newest step.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// Steps of the pilot so far.
    pub steps: u64,
    /// The outcome of the newest step; `None` before the first.
    pub outcome: Option<Outcome>,
    /// The rates handed to the link, in the vehicle's own signs.
    pub rates: VehicleRates,
    /// The law; `None`: a law that cannot be chosen on the console.
    pub law: Option<LawId>,
    /// The video.
    pub video: VideoSnapshot,
    /// The other video; `None`: there is one.
    pub other_video: Option<SourceSnapshot>,
    /// The vehicle and its link.
    pub vehicle: VehicleSnapshot,
    /// The link to the boat that is commanded.
    pub vessel: VehicleSnapshot,
    /// What the boat said last, and when.
    pub vessel_text: Option<(VehicleText, Timestamp)>,
    /// Where the followed boat is on the water, where that is known.
    pub boat: Option<BoatOnWater>,
    /// The recording.
    pub recording: RecordingState,
    /// The camera's work, and that of the paper's schema beside it.
    pub work: CameraWork,
    /// Alarms in force.
    pub alarms: Vec<Alarm>,
    /// Presses of Stop that the pilot has taken.
    pub stops_taken: u64,
    /// Steps, and turns of a live run's loop without one.
    pub beats: u64,
    /// The simulated world, where the vehicle is a simulator.
    pub world: Option<WorldState>,
    /// The drill that goes on in a demo.
    pub drill: Option<DrillState>,
    /// The boat and the time of a demo.
    pub drive: Option<DriveState>,
}

/// What is known of the source of a video.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SourceSnapshot {
    /// The state of the source.
    pub state: VideoSourceState,
    /// What the times of the pictures tell.
    pub timing: VideoTiming,
    /// The same in words, where the pictures are not in time.
    pub timing_text: Option<Arc<str>>,
}

/// The state of the tracked video.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VideoSnapshot {
    /// Which of the videos this is.
    pub number: VideoNumber,
    /// Its source.
    pub source: SourceSnapshot,
    /// The newest video frame that the pilot processed: time of capture and size.
    pub frame: Option<(Timestamp, PictureSize)>,
    /// Age of that frame when the pilot had processed it.
    pub age: Option<Duration>,
    /// Frames a second.
    pub fps: f64,
    /// Median time that the loop took for a frame, until the rates were handed to the link, over the last
    /// frames.
    pub step_time: Option<Duration>,
    /// Frames that were replaced by newer ones before the pilot took them.
    pub dropped: u64,
}

/// The state of a video source.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum VideoSourceState {
    /// Connecting for the first time.
    #[default]
    Connecting,
    /// Delivering.
    Up,
    /// Lost for this reason; reconnecting.
    Lost(String),
    /// Ended.
    Ended,
}

/// The state of the recording.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum RecordingState {
    /// There is no recording.
    #[default]
    Off,
    /// Recording to this file.
    On(String),
    /// The recording has stopped for this reason.
    Failed(String),
}
