//! The link to a simulated camera: the world reads the requested rates at each tick.
//!
//! The link has the dead-man's switch of a real link: rates that move the camera expire without a renewal.

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_sim::camera_mount::TICKS_PER_TILT_REPORT;
use barrelman_vocab::{Angle, Timestamp, VehicleRates};

use barrelman_link::{DeadMansSwitch, RequestedRates};

/// Longest time from the request to close until the camera rests: many ticks.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// The link to a simulated camera. Clones are the same link.
#[derive(Debug, Clone, Default)]
pub struct CameraLink(Arc<Shared>);

/// Where a camera is, and points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pointing {
    /// To the right.
    pub pan: Angle,
    /// Upwards.
    pub tilt: Angle,
    /// Height above the water, metres.
    pub height_m: f64,
    /// Horizontal field of view; `None`: the camera does not zoom.
    pub field_of_view: Option<Angle>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    rates_read: Condvar,
    pose_listener: OnceLock<PoseListener>,
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraLink").field("state", &self.state).finish_non_exhaustive()
    }
}

/// Receives the reports of tilt and height.
type PoseListener = Box<dyn Fn(Pointing) + Send + Sync>;

#[derive(Debug, Default)]
struct State {
    requested: RequestedRates,
    switch: DeadMansSwitch,
    faults: FaultPlan,
    /// The rates that the camera received last.
    in_force: VehicleRates,
    pointing: Option<Pointing>,
    ticks_since_report: u32,
    has_world_ended: bool,
}

impl CameraLink {
    fn state(&self) -> MutexGuard<'_, State> {
        // Plain data, whole at any time: a panic elsewhere does not spoil it.
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the deliberate faults. Times count from the program's start.
    pub fn set_faults(&self, faults: FaultPlan) {
        self.state().faults = faults;
    }

    /// Requests rates, in the vehicle's own signs, which will be renewed by `renew_by`.
    pub fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.state().requested = RequestedRates { command: rates, renew_by };
    }

    /// Requests latched rates: they last until the next request, as those of a vehicle that keeps its last
    /// rate.
    pub fn send_latched(&self, rates: VehicleRates) {
        self.send(rates, Some(Timestamp::from_nanos(u64::MAX)));
    }

    /// Where the camera points; `None` before the first tick of the world.
    pub fn pointing(&self) -> Option<Pointing> {
        self.state().pointing
    }

    /// Reports where the camera is and points, at 10 Hz; the callback must not block. Only the first callback
    /// is used.
    pub fn on_pose_report(&self, listener: impl Fn(Pointing) + Send + Sync + 'static) {
        let _ = self.0.pose_listener.set(Box::new(listener));
    }

    /// For the world: reports where the camera points at this tick.
    pub fn set_pointing(&self, pointing: Pointing) {
        let is_due = {
            let mut state = self.state();
            state.pointing = Some(pointing);
            state.ticks_since_report = (state.ticks_since_report + 1) % TICKS_PER_TILT_REPORT;
            state.ticks_since_report == 0
        };
        if let Some(listener) = self.0.pose_listener.get().filter(|_| is_due) {
            listener(pointing);
        }
    }

    /// Requests rest and waits until the camera has received it. Returns whether the camera rests.
    pub fn close(&self) -> bool {
        let mut state = self.state();
        state.requested = RequestedRates::REST;
        let is_moving = |state: &mut State| !state.in_force.is_rest() && !state.has_world_ended;
        let (state, _) = self
            .0
            .rates_read
            .wait_timeout_while(state, CLOSE_TIMEOUT, is_moving)
            .unwrap_or_else(PoisonError::into_inner);
        state.in_force.is_rest() || state.has_world_ended
    }

    /// For the world: the rates of this tick.
    pub fn read_rates(&self, now: Timestamp) -> VehicleRates {
        let mut state = self.state();
        let interruptions = [FaultKind::Drop, FaultKind::Stall, FaultKind::Disconnect];
        if interruptions.into_iter().any(|kind| state.faults.is_active(kind, now)) {
            return state.in_force;
        }
        let requested = state.requested;
        state.in_force = state.switch.command_in_force(&requested, now, || {
            tracing::error!("the pilot is held up: the link rests the camera");
        });
        self.0.rates_read.notify_all();
        state.in_force
    }

    /// For the world: the simulated camera no longer exists.
    pub fn end_world(&self) {
        self.state().has_world_ended = true;
        self.0.rates_read.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::AngularRate;

    use super::*;

    const MOVING: VehicleRates =
        VehicleRates { yaw: AngularRate::from_radians_per_second(0.3), ..VehicleRates::REST };

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    #[test]
    fn rates_that_are_not_renewed_end() {
        let link = CameraLink::default();
        link.send(MOVING, Some(at(100)));
        assert_eq!(
            [link.read_rates(at(90)), link.read_rates(at(149)), link.read_rates(at(150))],
            [MOVING, MOVING, VehicleRates::REST]
        );
        link.send(MOVING, None);
        assert!(link.read_rates(at(160)).is_rest(), "rates that move need a time by which they are renewed");
    }

    #[test]
    fn the_tilt_is_reported_ten_times_a_second() {
        let link = CameraLink::default();
        let reports = Arc::new(Mutex::new(Vec::new()));
        let listener = Arc::clone(&reports);
        link.on_pose_report(move |pose| listener.lock().unwrap().push(pose.tilt.degrees().round() as i32));
        for tick in 1..=120 {
            let tilt = Angle::from_degrees(-f64::from(tick));
            link.set_pointing(Pointing { pan: Angle::ZERO, tilt, height_m: 10.0, field_of_view: None });
        }
        assert_eq!(*reports.lock().unwrap(), [-12, -24, -36, -48, -60, -72, -84, -96, -108, -120]);
    }

    #[test]
    fn a_broken_link_leaves_the_camera_as_it_was() {
        let link = CameraLink::default();
        link.set_faults(FaultPlan::parse("drop@1+1").unwrap());
        link.send(MOVING, Some(at(900)));
        assert_eq!(link.read_rates(at(800)), MOVING);
        link.send(VehicleRates::REST, None);
        assert_eq!([link.read_rates(at(1500)), link.read_rates(at(2100))], [MOVING, VehicleRates::REST]);
    }

    #[test]
    fn the_last_zeros_are_waited_for_unless_the_world_has_ended() {
        let link = CameraLink::default();
        link.send(MOVING, Some(at(100)));
        link.read_rates(at(0));
        link.end_world();
        assert!(link.close());
    }
}
