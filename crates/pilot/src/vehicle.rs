//! What the pilot knows of the vehicle and of the way its commands take: whether they reach a camera that may
//! move.
//!
//! ```text
//!   level: rests the camera as long as it lasts         edge: ends the engagement, until the next Engage
//!   dry run                                             control was taken away
//!   link not up                                         the vehicle restarted
//!   commands not accepted                               the vehicle fell silent, or was not there at first
//!                                                       an emergency, or a landing, begins
//!   landing, emergency                                  a battery becomes low
//!                                                       another gimbal, camera or stream is used
//! ```
//!
//! A vehicle's protocol that does not know some of these never reports them.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{HoldCause, StopCause, UsedEquipment, ZoomAbility};

/// Where the commands of a pilot go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum CommandPath {
    /// To a simulated camera, which is always there.
    #[default]
    Simulated,
    /// Over a link that reports its state. It is not up until it says so.
    Link,
    /// Nowhere: a dry run shows advice only.
    DryRun,
}

/// The vehicle's clock may be reported this much earlier than before without a restart, seconds.
const UPTIME_TOLERANCE_S: f64 = 1.0;

/// The newest state of the vehicle and its link.
#[derive(Debug, Clone, Copy)]
pub struct VehicleState {
    path: CommandPath,
    link: LinkState,
    /// Whether the link has reported its state.
    has_reported: bool,
    /// Whether it has reported no more than that it is being opened: the vehicle was never there.
    is_absent: bool,
    /// Since the link came up.
    control: Option<ControlState>,
    /// Since the link began to come up, of a vehicle that answers commands.
    acceptance: Option<Acceptance>,
    /// Whether such a vehicle has accepted commands, and no other client has taken the control since.
    has_accepted: bool,
    uptime_s: Option<f64>,
    flight: Option<FlightState>,
    is_battery_low: bool,
    /// Whether the camera zooms, also while the link is lost.
    zoom: ZoomAbility,
    /// What is used, also while the link is lost.
    equipment: UsedEquipment,
}

impl VehicleState {
    /// The state at the start of a run.
    pub const fn new(path: CommandPath) -> Self {
        Self {
            path,
            link: LinkState::Opening,
            has_reported: false,
            is_absent: false,
            control: None,
            acceptance: None,
            has_accepted: false,
            uptime_s: None,
            flight: None,
            is_battery_low: false,
            zoom: ZoomAbility::NotKnown,
            equipment: UsedEquipment { gimbal: None, camera: None, stream: None },
        }
    }

    /// Where the commands go.
    pub const fn path(&self) -> CommandPath {
        self.path
    }

    /// Takes a report. Returns why an engagement ends by it.
    pub fn on_report(&mut self, report: &Report) -> Option<StopCause> {
        if self.path != CommandPath::Link {
            return None;
        }
        match *report {
            Report::Link(link) => {
                let was_absent = self.is_absent || !self.has_reported;
                self.is_absent = was_absent && link == LinkState::Opening;
                (self.link, self.has_reported) = (link, true);
                if link != LinkState::Up {
                    (self.control, self.acceptance, self.has_accepted) = (None, None, false);
                }
                (link == LinkState::Silent || self.is_absent).then_some(StopCause::VehicleSilent)
            }
            Report::Ground { control, uptime_s, .. } | Report::Control { control, uptime_s } => {
                let last_uptime_s = self.uptime_s.replace(uptime_s);
                let has_restarted = last_uptime_s.is_some_and(|last| uptime_s < last - UPTIME_TOLERANCE_S);
                // The start-up sequence gives the control away and takes it.
                let counted = (self.link == LinkState::Up).then_some(control);
                let before = core::mem::replace(&mut self.control, counted);
                let is_taken = before == Some(ControlState::Ours)
                    && matches!(counted, Some(ControlState::Unclaimed | ControlState::Elsewhere));
                match (has_restarted, is_taken) {
                    (true, _) => Some(StopCause::VehicleRestarted),
                    (false, true) => Some(StopCause::ControlLost),
                    (false, false) => None,
                }
            }
            Report::Acceptance(said) => {
                self.acceptance = Some(said);
                let is_taken = self.has_accepted && said.is_elsewhere();
                self.has_accepted = !is_taken && (self.has_accepted || said == Acceptance::Accepted);
                is_taken.then_some(StopCause::ControlLost)
            }
            Report::Flight { state, is_battery_low, .. } | Report::FlightState { state, is_battery_low } => {
                let begins = self.flight.replace(state) != Some(state);
                let becomes_low = is_battery_low && !self.is_battery_low;
                self.is_battery_low = is_battery_low;
                match state {
                    FlightState::Emergency if begins => Some(StopCause::Emergency),
                    FlightState::Landing if begins => Some(StopCause::Landing),
                    _ => becomes_low.then_some(StopCause::BatteryLow),
                }
            }
            Report::Equipment(used) => {
                let before = self.equipment.on_used(used)?.before;
                before.is_some().then_some(StopCause::Exchanged)
            }
            Report::Zoom(told) => {
                self.zoom = told;
                None
            }
            _ => None,
        }
    }

    /// Whether the camera zooms. One that no vehicle can tell of does if its profile says so.
    pub const fn zoom(&self) -> ZoomAbility {
        match self.path {
            CommandPath::Simulated | CommandPath::DryRun => ZoomAbility::Present,
            CommandPath::Link => self.zoom,
        }
    }

    /// Whether the vehicle was never there: a consent now would move the camera whenever it comes.
    pub const fn is_absent(&self) -> bool {
        self.is_absent
    }

    /// Why no command may move the camera now; `None`: commands reach a camera that may move.
    pub fn obstacle(&self) -> Option<HoldCause> {
        match self.path {
            CommandPath::Simulated => None,
            CommandPath::DryRun => Some(HoldCause::DryRun),
            CommandPath::Link if self.link != LinkState::Up => Some(HoldCause::LinkDown),
            CommandPath::Link => match (self.control, self.flight) {
                (Some(ControlState::Unclaimed | ControlState::Elsewhere), _) => Some(HoldCause::NoControl),
                _ if self.acceptance.is_some_and(|said| said != Acceptance::Accepted) => {
                    Some(HoldCause::NoControl)
                }
                (_, Some(FlightState::Emergency)) => Some(HoldCause::Emergency),
                (_, Some(FlightState::Landing)) => Some(HoldCause::Landing),
                _ => None,
            },
        }
    }
}
