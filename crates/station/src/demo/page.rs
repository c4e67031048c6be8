//! The state shared by a drive and its page: the newest picture and status, and the queue of inputs.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use serde::Serialize;
use tokio::sync::watch;

use barrelman_experiments::drive::DriveInput;

/// Inputs that may wait for the next tick.
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
    /// Its seed.
    pub seed: u64,
    /// Ticks since the drive's start: 120 a second.
    pub tick: u64,
    /// The same in seconds.
    pub time_s: f64,
    /// Whether the time stands still.
    pub paused: bool,
    /// Simulated seconds in each second.
    pub pace: f64,
    /// The camera law.
    pub law: &'static str,
    /// The pilot's mode, in words.
    pub mode: String,
    /// Whether the camera may move.
    pub engaged: bool,
    /// `unseeded`, `tracking`, `coasting` or `lost`.
    pub track: &'static str,
    /// How sure the tracker is, 0 to 1.
    pub confidence: Option<f64>,
    /// P: above 1 outside of the region.
    pub p: Option<f64>,
    /// P as the paper's schema would have kept it; absent where it is the law.
    pub schema_p: Option<f64>,
    /// What is in force, rad/s: pan to the right, tilt upwards.
    pub pan: f64,
    /// See `pan`.
    pub tilt: f64,
    /// What was sent, in the vehicle's own signs, rad/s.
    pub yaw_rate: f64,
    /// See `yaw_rate`.
    pub pitch_rate: f64,
    /// What the camera does, rad/s.
    pub achieved: (f64, f64),
    /// How fast the boat goes ahead, m/s.
    pub speed_m_per_s: f64,
    /// `page`, `helmsman`, or `nobody` where the target cannot be steered.
    pub helm: &'static str,
    /// What the page steers, -1 to 1; rudder to the left above 0.
    pub thrust: f64,
    /// See `thrust`.
    pub rudder: f64,
    /// Whether the boat is in the picture.
    pub in_picture: Option<bool>,
    /// Whether the drive is over.
    pub over: bool,
}

impl PageState {
    /// A state without a picture, and the receiver of the inputs.
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

    /// The pictures as they come; empty before the first.
    pub(super) fn pictures(&self) -> watch::Receiver<Bytes> {
        self.pictures.subscribe()
    }

    /// Publishes the state of the drive.
    pub fn set_status(&self, status: &DriveStatus) {
        if let Ok(text) = serde_json::to_string(status) {
            *self.status.lock().unwrap_or_else(PoisonError::into_inner) = text;
        }
    }

    pub(super) fn status(&self) -> String {
        self.status.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Queues an input. Returns `false` where the queue is full.
    pub(super) fn queue_input(&self, input: DriveInput) -> bool {
        self.inputs.try_send(input).is_ok()
    }
}
