//! The link to a simulated camera: rates go in on one side, and the world takes them at its next tick.
//!
//! It has the dead man's switch of a real link: rates that move are in force until the time by which they were to be
//! renewed, and a little longer; then the camera rests.

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use barrelman_sim::camera_mount::TICKS_PER_TILT_REPORT;
use barrelman_vocab::{Angle, Timestamp, VehicleRates};

use super::worker::RENEWAL_GRACE;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// How long the last zeros may take to the camera: many ticks.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// The way to a simulated camera. Clones are the same link.
#[derive(Debug, Clone, Default)]
pub struct CameraLink(Arc<Shared>);

/// Where a camera points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pointing {
    /// To the right.
    pub pan: Angle,
    /// Upwards.
    pub tilt: Angle,
}

#[derive(Default)]
struct Shared {
    asked: Mutex<Asked>,
    taken: Condvar,
    listener: OnceLock<Listener>,
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraLink").field("asked", &self.asked).finish_non_exhaustive()
    }
}

/// Whom the gimbal reports its tilt to.
type Listener = Box<dyn Fn(Angle) + Send + Sync>;

#[derive(Debug, Default)]
struct Asked {
    rates: VehicleRates,
    renew_by: Option<Timestamp>,
    faults: FaultPlan,
    /// What the camera was told last.
    in_force: VehicleRates,
    pointing: Option<Pointing>,
    told: u32,
    world_ended: bool,
    overdue: bool,
}

impl CameraLink {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        // Plain data, whole at any time: a panic elsewhere does not spoil it.
        self.0.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is to go wrong on it; times count from the program's start.
    pub fn set_faults(&self, faults: FaultPlan) {
        self.asked().faults = faults;
    }

    /// Asks for rates, in the vehicle's own signs, which are renewed by `renew_by`.
    pub fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        let mut asked = self.asked();
        (asked.rates, asked.renew_by) = (rates, renew_by);
    }

    /// Asks for rates that last until others are asked for, as a vehicle that keeps its last rate does.
    pub fn keep(&self, rates: VehicleRates) {
        self.send(rates, Some(Timestamp::from_nanos(u64::MAX)));
    }

    /// Where the camera points.
    pub fn pointing(&self) -> Option<Pointing> {
        self.asked().pointing
    }

    /// Lets the gimbal report the camera's tilt, ten times a second, to whom must not make the world wait. Only the
    /// first one who asks is told.
    pub fn on_tilt_report(&self, listener: impl Fn(Angle) + Send + Sync + 'static) {
        let _ = self.0.listener.set(Box::new(listener));
    }

    /// For the world: where the camera points at this tick.
    pub fn tell(&self, pointing: Pointing) {
        let is_due = {
            let mut asked = self.asked();
            asked.pointing = Some(pointing);
            asked.told = (asked.told + 1) % TICKS_PER_TILT_REPORT;
            asked.told == 0
        };
        if let Some(listener) = self.0.listener.get().filter(|_| is_due) {
            listener(pointing.tilt);
        }
    }

    /// Asks for rest, and waits until the camera was told so. Returns whether it was.
    pub fn close(&self) -> bool {
        let mut asked = self.asked();
        (asked.rates, asked.renew_by) = (VehicleRates::REST, None);
        let moves = |asked: &mut Asked| !asked.in_force.is_rest() && !asked.world_ended;
        let (asked, _) = self
            .0
            .taken
            .wait_timeout_while(asked, CLOSE_TIMEOUT, moves)
            .unwrap_or_else(PoisonError::into_inner);
        asked.in_force.is_rest() || asked.world_ended
    }

    /// For the world: the rates of this tick.
    pub fn take(&self, now: Timestamp) -> VehicleRates {
        let mut asked = self.asked();
        let deaf = [FaultKind::Drop, FaultKind::Stall, FaultKind::Disconnect];
        if deaf.into_iter().any(|kind| asked.faults.is_active(kind, now)) {
            return asked.in_force;
        }
        let moves = !asked.rates.is_rest();
        let expired = moves && asked.renew_by.is_none_or(|at| at.plus(RENEWAL_GRACE) <= now);
        if expired && !asked.overdue {
            tracing::error!("the pilot is held up: the link rests the camera");
        }
        asked.overdue = expired;
        asked.in_force = if expired { VehicleRates::REST } else { asked.rates };
        self.0.taken.notify_all();
        asked.in_force
    }

    /// For the world: there is no camera any more.
    pub fn world_ended(&self) {
        self.asked().world_ended = true;
        self.0.taken.notify_all();
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
            [link.take(at(90)), link.take(at(149)), link.take(at(150))],
            [MOVING, MOVING, VehicleRates::REST]
        );
        link.send(MOVING, None);
        assert!(link.take(at(160)).is_rest(), "rates that move need a time by which they are renewed");
    }

    #[test]
    fn the_tilt_is_reported_ten_times_a_second() {
        let link = CameraLink::default();
        let told = Arc::new(Mutex::new(Vec::new()));
        let listener = Arc::clone(&told);
        link.on_tilt_report(move |tilt| listener.lock().unwrap().push(tilt.degrees().round() as i32));
        for tick in 1..=120 {
            link.tell(Pointing { pan: Angle::ZERO, tilt: Angle::from_degrees(-f64::from(tick)) });
        }
        assert_eq!(*told.lock().unwrap(), [-12, -24, -36, -48, -60, -72, -84, -96, -108, -120]);
    }

    #[test]
    fn a_broken_link_leaves_the_camera_as_it_was() {
        let link = CameraLink::default();
        link.set_faults(FaultPlan::parse("drop@1+1").unwrap());
        link.send(MOVING, Some(at(900)));
        assert_eq!(link.take(at(800)), MOVING);
        link.send(VehicleRates::REST, None);
        assert_eq!([link.take(at(1500)), link.take(at(2100))], [MOVING, VehicleRates::REST]);
    }

    #[test]
    fn the_last_zeros_are_waited_for_unless_the_world_has_ended() {
        let link = CameraLink::default();
        link.send(MOVING, Some(at(100)));
        link.take(at(0));
        link.world_ended();
        assert!(link.close());
    }
}
