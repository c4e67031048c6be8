//! The process of a guard: what it needs, its start, and its end.

use std::io;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_wire::{ByteProtocol, LinkHistory};

use crate::guard::message::{GuardedVehicle, Settings, ToGuard};
use crate::guard::pipe::Pipe;
use crate::url::LinkUrl;
use crate::vehicle_lock::VehicleLock;

/// Longest wait for the end of a guard that was killed. One that does not end is left to the system: the next
/// guard cannot open a port before it is gone.
const REAPING_TIMEOUT: Duration = Duration::from_millis(50);
const REAPING_INTERVAL: Duration = Duration::from_millis(2);

/// What a guarded link needs.
#[derive(Debug, Clone)]
pub struct GuardedLinkSettings<P = ByteProtocol> {
    /// The guard's program.
    pub guard: PathBuf,
    /// The address of the vehicle.
    pub url: LinkUrl,
    /// What is spoken there.
    pub protocol: P,
    /// What the guard has to know of the vehicle.
    pub vehicle: GuardedVehicle,
    /// The lock of the vehicle, which the guard holds, too, until it has sent its zeros; `None`: without a
    /// lock.
    pub lock: Option<Arc<VehicleLock>>,
    /// The program's clock.
    pub clock: Clock,
}

/// A guard's process and its pipe.
pub(super) struct Guard {
    child: Child,
    pub(super) pipe: Arc<Pipe>,
}

impl Guard {
    /// Starts a guard. `history`: what a guard before it has left.
    pub(super) fn start<P>(settings: &GuardedLinkSettings<P>, history: LinkHistory) -> io::Result<Self> {
        let (pipe, other): (Pipe, OwnedFd) = Pipe::pair()?;
        let first: ToGuard = ToGuard::Settings(Settings {
            clock_start_ns: settings.clock.start_on_monotonic_ns(),
            vehicle: settings.vehicle,
            history,
            url: settings.url.with_faults(),
        });
        pipe.send(&first.encode());
        let held = match &settings.lock {
            Some(lock) => Stdio::from(lock.share()?),
            None => Stdio::null(),
        };
        let child = Command::new(&settings.guard).stdin(Stdio::from(other)).stdout(held).spawn()?;
        Ok(Self { child, pipe: Arc::new(pipe) })
    }

    /// Ends a guard that is gone, hung, or has ended by itself. A stopped process ends by the kill, too, and
    /// leaves its port.
    pub(super) fn reap(mut self) {
        let _ = self.child.kill();
        let killed_at = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && killed_at.elapsed() < REAPING_TIMEOUT {
            std::thread::sleep(REAPING_INTERVAL);
        }
    }
}
