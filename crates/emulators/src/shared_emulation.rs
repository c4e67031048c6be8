//! What the server and the ticks of an emulated vehicle over HTTP share: its state, and the faults of the way
//! there and back.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// Interval of the ticks that end motions, and of the log.
pub(crate) const TICK: Duration = Duration::from_millis(5);
/// Largest body of a request, bytes.
pub(crate) const MAX_BODY_BYTES: usize = 16 << 10;
/// Delay of answers while the fault `delay` is active.
const FAULT_DELAY: Duration = Duration::from_millis(400);
/// Interval at which a request that hangs looks whether the fault is over.
const FAULT_LOOK: Duration = Duration::from_millis(20);

/// The state of an emulated vehicle.
pub(crate) struct Shared<E> {
    state: Mutex<E>,
    faults: FaultPlan,
    pub(crate) clock: Clock,
}

impl<E> Shared<E> {
    pub(crate) const fn new(state: E, faults: FaultPlan, clock: Clock) -> Self {
        Self { state: Mutex::new(state), faults, clock }
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, E> {
        // A panic of one request must not end the emulation.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn is_active(&self, kind: FaultKind) -> bool {
        self.faults.is_active(kind, self.clock.now())
    }

    /// A request is on its way to the vehicle.
    pub(crate) async fn way_there(&self) {
        self.wait_while(FaultKind::Hang).await;
    }

    /// The answer is on its way back, and may be damaged: these characters are others then.
    pub(crate) async fn way_back(&self, body: String, damaged: [char; 2]) -> String {
        self.wait_while(FaultKind::Silence).await;
        if self.is_active(FaultKind::Delay) {
            tokio::time::sleep(FAULT_DELAY).await;
        }
        if self.is_active(FaultKind::Corrupt) { body.replace(damaged, "#") } else { body }
    }

    async fn wait_while(&self, kind: FaultKind) {
        while self.is_active(kind) {
            tokio::time::sleep(FAULT_LOOK).await;
        }
    }
}
