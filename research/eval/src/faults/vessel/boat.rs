//! The far end of the line to a boat, of any protocol.

use barrelman_vocab::VesselCommand;

use super::super::line::Line;

/// The far end of the line, with its boat.
pub(super) trait Boat {
    /// Lets a millisecond pass. `trace` takes what is received.
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str));

    /// The command in force at the boat.
    fn command(&self, at_ms: u64) -> VesselCommand;

    /// Whether a packet of the link tells the boat to move.
    fn tells_to_move(&self, packet: &[u8]) -> bool;

    /// Whether another commander steers the boat.
    fn is_anothers(&self) -> bool {
        false
    }

    /// Whether this program commanded the boat in the newest millisecond though another commander steers it.
    fn is_meddled_with(&self) -> bool {
        false
    }
}
