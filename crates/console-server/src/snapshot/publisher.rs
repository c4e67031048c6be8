//! Builds the snapshot of each step, and writes the event log.

use barrelman_experiments::drill::DrillState;
use std::sync::Arc;
use std::time::Duration;

use barrelman_pilot::{Input, Outcome, VesselMode};
use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState};
use barrelman_vocab::{
    Angle, HoldCause, LawId, Named as _, PixelBox, Timestamp, Track, VehicleProfile, VehicleRates,
};
use tokio::sync::watch;

use super::alarm::Alarm;
use super::boat_on_water::BoatFinder;
use super::event_log::{EventLog, Level};
use super::frame_rate::FrameRate;
use super::pose_reports::PoseReports;
use super::step_time::StepTime;
use super::text_rate::TextRate;
use super::vehicle::LinkStatus;
use super::{DriveState, RecordingState, SharedSnapshot, Snapshot, VideoSourceState, WorldState};
use barrelman_pilot::Mode;
use barrelman_pilot::net_yaw::NetYawLevel;
use barrelman_trial::camera_work::CameraWorkMeter;

mod logging;
mod video;

/// Nearer to an end stop than this, the alarm is raised, rad (3 degrees).
const END_STOP_MARGIN_RAD: f64 = 0.052;

/// Publishes a snapshot after each step.
pub struct Publisher {
    state: Snapshot,
    snapshots: watch::Sender<SharedSnapshot>,
    events: Arc<EventLog>,
    frames: FrameRate,
    step_time: StepTime,
    work: CameraWorkMeter,
    boat: BoatFinder,
    tilt_stops: (f64, f64),
    is_console_lost: bool,
    /// The boat's mode when its acceptance was logged last.
    logged_mode: Option<DriveMode>,
    texts: TextRate,
    pose_reports: PoseReports,
}

impl Publisher {
    /// A publisher of a session with this vehicle and link.
    pub fn new(profile: &VehicleProfile, link: LinkStatus, recording: RecordingState) -> Self {
        let mut state = Snapshot { recording, ..Snapshot::default() };
        state.vehicle.link = link;
        let (low, high) = profile.camera.tilt_stops;
        Self {
            snapshots: watch::Sender::new(Arc::new(state.clone())),
            state,
            events: Arc::default(),
            frames: FrameRate::default(),
            step_time: StepTime::default(),
            work: CameraWorkMeter::new(profile),
            boat: BoatFinder::new(profile),
            tilt_stops: (low.radians(), high.radians()),
            is_console_lost: false,
            logged_mode: None,
            texts: TextRate::default(),
            pose_reports: PoseReports::default(),
        }
    }

    /// Nothing reaches a camera that was turning. The alarm lasts until zeros have been sent on a reopened
    /// port.
    pub fn set_may_be_turning(&mut self, text: &str, now: Timestamp) {
        self.state.vehicle.may_be_moving = true;
        self.events.add(now, Level::Alarm, "camera-may-turn", text.to_owned());
        self.publish(now);
    }

    /// Nothing reaches a boat that was under way. The alarm lasts until neutral commands have been sent on a
    /// reopened port.
    pub fn set_boat_may_move(&mut self, now: Timestamp) {
        self.state.vessel.may_be_moving = true;
        self.publish(now);
    }

    /// The newest snapshot, for readers.
    pub fn subscribe(&self) -> watch::Receiver<SharedSnapshot> {
        self.snapshots.subscribe()
    }

    /// The event log.
    pub fn events(&self) -> Arc<EventLog> {
        Arc::clone(&self.events)
    }

    /// The newest snapshot.
    pub const fn newest(&self) -> &Snapshot {
        &self.state
    }

    /// The pilot made a step.
    pub fn on_step(&mut self, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates, law: LawId) {
        match input {
            Input::Frame(frame) => {
                self.frames.add(outcome.at);
                self.state.video.frame = Some((frame.capture.at, frame.picture.size()));
                self.state.video.age = outcome.age;
            }
            Input::Telemetry(telemetry) => {
                let before = self.state.vehicle;
                self.state.vehicle.on_telemetry(telemetry);
                self.pose_reports.note(telemetry);
                self.log_link_change("link", before.link, self.state.vehicle.link, outcome.at);
                self.log_acceptance(before.acceptance, outcome.at);
                self.log_equipment(before.equipment, telemetry);
            }
            Input::VesselTelemetry(telemetry) => {
                let before = self.state.vessel;
                self.state.vessel.on_telemetry(telemetry);
                self.log_link_change("boat-link", before.link, self.state.vessel.link, outcome.at);
                self.log_vessel(&before, telemetry);
            }
            Input::Localisation(_) | Input::Detections(_) | Input::Request(_) | Input::Tick => {}
        }
        self.work.on_step(outcome);
        self.log_outcome(outcome);
        self.pose_reports.forget_old(&mut self.state.vehicle, outcome.at);
        self.state.boat = self.boat.find(outcome.track, &self.state.vehicle, outcome.earth);
        self.state.steps += 1;
        self.state.beats += 1;
        self.state.outcome = Some(outcome.clone());
        self.state.rates = rates;
        self.state.law = Some(law);
        self.publish(outcome.at);
    }

    /// The loop took a turn in which the pilot had nothing to decide.
    pub fn on_idle_turn(&mut self, now: Timestamp) {
        self.state.beats += 1;
        self.publish(now);
    }

    /// The link to the boat that is commanded. Published with the next step.
    pub const fn set_vessel_link(&mut self, link: LinkStatus) {
        self.state.vessel.link = link;
    }

    /// The simulated world at the start of a session.
    pub fn set_world(&mut self, world: WorldState, now: Timestamp) {
        self.state.world = Some(world);
        self.publish(now);
    }

    /// The true bounds of the boat in the newest picture of a demo. Published with the next state of the
    /// drive.
    pub fn set_boat(&mut self, boat: Option<PixelBox>) {
        if let Some(world) = &mut self.state.world {
            world.boat = boat.map(|PixelBox { u, v, w, h }| [u, v, w, h]);
        }
    }

    /// Another simulated world takes the place of the one before.
    pub fn begin_world(&mut self, world: WorldState, now: Timestamp) {
        let text = format!(
            "new drive: {}, seed {}: the camera is disengaged, and nothing is marked",
            world.scenario, world.seed
        );
        self.events.add(now, Level::Info, "new-drive", text);
        self.set_world(world, now);
    }

    /// A drive with a pilot of its own begins: its times and figures do not follow those of the drive before.
    pub fn begin_drive(&mut self, profile: &VehicleProfile, now: Timestamp) {
        (self.frames, self.boat) = (FrameRate::default(), BoatFinder::new(profile));
        self.work = CameraWorkMeter::new(profile);
        let (low, high) = profile.camera.tilt_stops;
        self.tilt_stops = (low.radians(), high.radians());
        (self.state.outcome, self.state.boat) = (None, None);
        self.publish(now);
    }

    /// Frames that were replaced before the pilot took them, so far. Published with the next step.
    pub fn set_dropped(&mut self, dropped: u64) {
        self.state.video.dropped = dropped;
    }

    /// The presses of Stop that the pilot has taken. Published with the next step.
    pub fn set_stops_taken(&mut self, stops: u64) {
        self.state.stops_taken = stops;
    }

    /// The loop took this long for a video frame. Published with the next step.
    pub fn add_step_time(&mut self, taken: Duration) {
        self.step_time.add(taken);
        self.state.video.step_time = self.step_time.median();
    }

    /// The law in force.
    pub fn set_law(&mut self, law: LawId, now: Timestamp) {
        if self.state.law != Some(law) {
            self.state.law = Some(law);
            self.publish(now);
        }
    }

    /// Where the simulated camera of a demo is, and points. Published with the next step.
    pub fn set_camera(&mut self, tilt: Angle, height_m: f64) {
        (self.state.vehicle.tilt, self.state.vehicle.altitude_m) = (Some(tilt), Some(height_m));
    }

    /// The state of a demo's world.
    pub fn set_drive(&mut self, drive: DriveState, now: Timestamp) {
        self.state.drive = Some(drive);
        self.publish(now);
    }

    /// The drill of a demo. Published with the next state of the drive.
    pub fn set_drill(&mut self, drill: Option<DrillState>) {
        self.state.drill = drill;
    }

    /// The state of the recording.
    pub fn set_recording(&mut self, recording: RecordingState, now: Timestamp) {
        if let RecordingState::Failed(reason) = &recording {
            let text = format!("{}: {reason}", Alarm::RecordingFailed.text());
            self.events.add(now, Level::Alarm, "recording-failed", text);
        }
        self.state.recording = recording;
        self.publish(now);
    }

    /// Whether the controlling page is gone.
    pub fn set_console_lost(&mut self, is_lost: bool, now: Timestamp) {
        if self.is_console_lost != is_lost {
            self.is_console_lost = is_lost;
            self.publish(now);
        }
    }

    fn publish(&mut self, now: Timestamp) {
        self.state.video.fps = self.frames.per_second(now);
        self.state.work = self.work.work(self.state.law);
        let alarms = self.alarms();
        for alarm in alarms.iter().filter(|alarm| !self.state.alarms.contains(alarm)) {
            // The recording's alarm is logged with its reason.
            if *alarm != Alarm::RecordingFailed {
                self.events.add(now, Level::Alarm, alarm.key(), alarm.text());
            }
        }
        self.state.alarms = alarms;
        self.snapshots.send_replace(Arc::new(self.state.clone()));
    }

    fn alarms(&self) -> Vec<Alarm> {
        let (state, vehicle) = (&self.state, &self.state.vehicle);
        let mode = state.outcome.as_ref().map(|outcome| outcome.mode);
        let is_engaged = mode.is_some_and(Mode::is_engaged);
        let is_lost = matches!(state.outcome.as_ref().map(|outcome| outcome.track), Some(Track::Lost { .. }));
        let is_at_stop = vehicle.tilt.is_some_and(|tilt| {
            let (low, high) = self.tilt_stops;
            tilt.radians() < low + END_STOP_MARGIN_RAD || tilt.radians() > high - END_STOP_MARGIN_RAD
        });
        let net_yaw = state.outcome.as_ref().map_or(NetYawLevel::Free, |outcome| outcome.net_yaw.level);
        let is_boat_commanded = state
            .outcome
            .as_ref()
            .is_some_and(|outcome| !matches!(outcome.vessel.mode, VesselMode::Absent | VesselMode::Released));
        [
            (Alarm::TrackLost, is_lost),
            (
                Alarm::StaleVideo,
                mode == Some(Mode::Holding(HoldCause::VideoStale))
                    || matches!(state.video.source.timing, VideoTiming::Late { .. }),
            ),
            (
                Alarm::NoVideo,
                mode == Some(Mode::Holding(HoldCause::VideoSilent))
                    || matches!(state.video.source.state, VideoSourceState::Lost(_)),
            ),
            (Alarm::LinkDown, vehicle.link.is_down()),
            (Alarm::CameraMayTurn, vehicle.may_be_moving),
            (Alarm::BoatLinkDown, is_boat_commanded && state.vessel.link.is_down()),
            (Alarm::BoatMayMove, state.vessel.may_be_moving),
            (
                Alarm::CameraTurns,
                state.outcome.as_ref().is_some_and(|outcome| outcome.unasked_motion.is_some()),
            ),
            (
                Alarm::BoatMoves,
                state.outcome.as_ref().is_some_and(|outcome| outcome.vessel.unasked_speed_m_per_s.is_some()),
            ),
            (Alarm::ControlLost, vehicle.control.is_some_and(|control| control != ControlState::Ours)),
            (Alarm::EndStop, is_at_stop),
            (Alarm::Emergency, vehicle.flight == Some(FlightState::Emergency)),
            (Alarm::BatteryLow, vehicle.is_battery_low),
            (Alarm::RecordingFailed, matches!(state.recording, RecordingState::Failed(_))),
            (Alarm::ConsoleLost, self.is_console_lost && is_engaged),
            (Alarm::Drill, state.drill.as_ref().is_some_and(|drill| drill.alarm)),
            (Alarm::NetYaw, net_yaw == NetYawLevel::Warned),
            (Alarm::NetYawLimit, net_yaw == NetYawLevel::Refused),
        ]
        .into_iter()
        .filter_map(|(alarm, is_raised)| is_raised.then_some(alarm))
        .collect()
    }
}

/// The state of a link as text.
pub const fn link_state_text(state: LinkState) -> &'static str {
    match state {
        LinkState::Opening => "link opening",
        LinkState::Starting => "link starting",
        LinkState::Up => "link up",
        LinkState::Silent => "the vehicle is silent",
        LinkState::Closing => "link closing",
        LinkState::Closed => "link closed",
    }
}

#[cfg(test)]
mod tests;
