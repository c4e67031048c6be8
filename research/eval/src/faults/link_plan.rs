//! How a link to a vehicle is made: whose session is opened, and what a guard lets pass.

use std::sync::Arc;

use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::ByteSession;

use super::mutant::Mutant;

/// Opens sessions with a vehicle.
pub(super) type Opener<C> = Arc<dyn Fn(Timestamp) -> Box<ByteSession<C>> + Send + Sync>;

/// How a link is made.
#[derive(Clone)]
pub(super) struct LinkPlan<C = VehicleRates> {
    pub(super) open_session: Opener<C>,
    /// The largest command that a guard lets pass; `None`: without a guard, the link is a thread of the
    /// program.
    pub(super) guard_limits: Option<C>,
    pub(super) mutant: Mutant,
}
