//! What a page or a program can request.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A request of the operator. Requests are refused with a reason, or accepted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ConsoleRequest {
    /// Track what this box contained. Replaces an earlier selection at any time. The answer comes when the track has
    /// been confirmed in the newest video frame (accepted), could not be confirmed (refused), or another selection came
    /// (superseded).
    Select {
        /// Left, top, width, height, pixels of the displayed picture, origin at the top left corner.
        #[serde(rename = "box")]
        bounds: [f64; 4],
        /// Time of capture of the video frame on which the box was drawn.
        captured_ns: u64,
    },
    /// "Not that one": forget the present track, and do not take that object again.
    Reject,
    /// Forget the target and follow nothing.
    Deselect,
    /// Let the program move the camera.
    Engage,
    /// Continue tracking with the camera at rest; also ends a stop.
    Disengage,
    /// Rest the camera at once, until the next `engage`. Taken from watchers, too.
    Stop,
    /// Turn the camera slowly while this is renewed, at least every 250 ms; while disengaged only.
    Nudge {
        /// Share of the nudge rate, -1 to 1, positive to the right.
        pan: f64,
        /// Share of the nudge rate, -1 to 1, positive upwards.
        tilt: f64,
    },
    /// Search for the boat that is lost, slowly: where it was seen last, then a sweep. A search ends by itself when the
    /// boat is found, and after a minute.
    Search,
    /// State by how much the vehicle is turned about the vertical, and the tether twisted.
    NetYaw {
        /// Degrees, positive to the right.
        degrees: f64,
    },
    /// Change the camera law; while not engaged only.
    Law {
        /// The law.
        law: LawName,
    },
    /// Steer the boat by hand for half a second; both 0: let go. Only a page on a socket can.
    Helm {
        /// -1 (astern) to 1 (ahead).
        thrust: f64,
        /// -1 (right) to 1 (left).
        rudder: f64,
    },
    /// Command the boat no more. In the demo, the scenario's helmsman then steers.
    Helmsman,
    /// Mark a point in the picture. The first place or person is the destination; a further one replaces a place.
    Mark {
        /// What is there.
        mark: MarkName,
        /// The point, pixels of the displayed picture, origin at the top left corner: u, v.
        at: [f64; 2],
        /// Time of capture of the video frame on which the mark was set, at most 1.5 s old.
        captured_ns: u64,
    },
    /// Move a mark to where what it marks is now. The mark of a person then drifts on as it was moved.
    MoveMark {
        /// Its number.
        id: u32,
        /// The point, pixels of the displayed picture: u, v.
        at: [f64; 2],
        /// Time of capture of the video frame on which the mark was moved, at most 1.5 s old.
        captured_ns: u64,
    },
    /// Remove a mark.
    Unmark {
        /// Its number.
        id: u32,
    },
    /// Remove all marks.
    UnmarkAll,
    /// The next place or person becomes the destination.
    NextMark,
    /// Let the boat go to the destination by itself. Only a page on a socket can; a second after the page is gone, the boat
    /// is stopped.
    Guide,
    /// Let the boat go to the mark `home` by itself. As with `guide`, only a page on a socket can.
    GoHome,
    /// Stop the boat alone.
    StopBoat,
    /// Pause the simulated world (demo only).
    Pause,
    /// Resume the simulated world (demo only).
    Resume,
    /// Take the control, also from another page, which is told.
    TakeControl,
    /// Ask the page in control for the control.
    AskControl,
    /// Give the control to another page.
    GiveControl {
        /// Number of the other page (`hello.client`).
        client: u64,
    },
}

/// What can be marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MarkName {
    /// A place: the boat goes there and stays.
    Place,
    /// A person: the boat stops before the stand-off, or keeps away from a person that is not the destination.
    Person,
    /// A point to pass on the way to the destination.
    WayPoint,
    /// The centre of an area of 5 m that the boat must not enter.
    Forbidden,
    /// The place to come back to.
    Home,
}

/// The camera laws that can be switched to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The paper's motor schema.
    Schema,
    /// Optimal law: least energy.
    MinimumEnergy,
    /// Optimal law: time in motion and energy.
    TimeFuel,
    /// Optimal law: longest rest.
    Eco,
    /// Optimal law: one movement for each excursion.
    Intermittent,
}
