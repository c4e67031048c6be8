//! The state shared by a drive and its page: the newest picture and status, and the queue of inputs.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use serde::Serialize;
use tokio::sync::watch;

use barrelman_experiments::drive::DriveInput;

/// Capacity of the input queue.
const INPUTS: usize = 64;

/// The newest picture and status for the page, and the inputs from the page.
pub struct PageState {
    pictures: watch::Sender<Bytes>,
    status: Mutex<String>,
    inputs: SyncSender<DriveInput>,
}

/// The state of a drive, for the page and for scripts.
#[derive(Debug, Clone, Serialize)]
pub struct DriveStatus {
    /// The scenario.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Ticks since the drive's start, 120 a second.
    pub tick: u64,
    /// Time since the drive's start, seconds.
    pub time_s: f64,
    /// Whether the drive is paused.
    pub paused: bool,
    /// Simulated seconds per second.
    pub pace: f64,
    /// The camera law.
    pub law: &'static str,
    /// The pilot's mode, in words.
    pub mode: String,
    /// Whether the camera may move.
    pub engaged: bool,
    /// `unseeded`, `tracking`, `coasting` or `lost`.
    pub track: &'static str,
    /// The tracker's confidence, 0 to 1.
    pub confidence: Option<f64>,
    /// P; above 1 outside of the region.
    pub p: Option<f64>,
    /// P as the paper's motor schema would have kept it; absent where the motor schema is the law.
    pub schema_p: Option<f64>,
    /// Pan rate in force, rad/s, positive to the right.
    pub pan: f64,
    /// Tilt rate in force, rad/s, positive upwards.
    pub tilt: f64,
    /// Yaw rate that was sent, in the vehicle's own sign, rad/s.
    pub yaw_rate: f64,
    /// Pitch rate that was sent, in the vehicle's own sign, rad/s.
    pub pitch_rate: f64,
    /// The camera's actual pan and tilt rates, rad/s.
    pub achieved: (f64, f64),
    /// The boat's speed ahead, m/s.
    pub speed_m_per_s: f64,
    /// Who steers: `page`, `helmsman`, or `nobody` where the target cannot be steered.
    pub helm: &'static str,
    /// The page's throttle, -1 to 1.
    pub thrust: f64,
    /// The page's rudder, -1 to 1, positive to the left.
    pub rudder: f64,
    /// Whether the boat is in the newest picture.
    pub in_picture: Option<bool>,
    /// Whether the drive is over.
    pub over: bool,
}

impl PageState {
    /// A state without a picture, and the queue of inputs.
    pub fn new() -> (Self, Receiver<DriveInput>) {
        let (inputs, queue) = sync_channel(INPUTS);
        (
            Self { pictures: watch::channel(Bytes::new()).0, status: Mutex::new("{}".to_owned()), inputs },
            queue,
        )
    }

    /// Publishes a picture to all viewers.
    pub fn set_picture(&self, jpeg: Bytes) {
        self.pictures.send_replace(jpeg);
    }

    /// Whether there is a viewer.
    pub fn has_viewer(&self) -> bool {
        self.pictures.receiver_count() > 0
    }

    /// Subscribes to the pictures; empty before the first.
    pub(super) fn pictures(&self) -> watch::Receiver<Bytes> {
        self.pictures.subscribe()
    }

    /// Publishes the state of the drive.
    pub fn set_status(&self, status: &DriveStatus) {
        if let Ok(text) = serde_json::to_string(status) {
            *self.status.lock().unwrap_or_else(PoisonError::into_inner) = text;
        }
    }

    /// The newest state of the drive as JSON; `{}` before the first.
    pub(super) fn status(&self) -> String {
        self.status.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Queues an input. Returns `false` where the queue is full.
    pub(super) fn queue_input(&self, input: DriveInput) -> bool {
        self.inputs.try_send(input).is_ok()
    }
}
