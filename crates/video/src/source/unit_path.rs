//! The way of the units from the line of a source to the decoder.

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::EncodedUnit;

/// The way of the units from the line of a source to the decoder.
pub(super) trait UnitPath: Send {
    /// Why the line is cut, while it is: a network source then loses its connection.
    fn cut(&self, at: Timestamp) -> Option<&'static str>;

    /// Takes the unit that arrived at `at`, if one did, and passes the units to decode now to `out`.
    fn pass(&mut self, unit: Option<EncodedUnit>, at: Timestamp, out: &mut dyn FnMut(EncodedUnit));
}

/// The way on which every unit goes to the decoder at once.
pub(super) struct DirectPath;

impl UnitPath for DirectPath {
    fn cut(&self, _at: Timestamp) -> Option<&'static str> {
        None
    }

    fn pass(&mut self, unit: Option<EncodedUnit>, _at: Timestamp, out: &mut dyn FnMut(EncodedUnit)) {
        if let Some(unit) = unit {
            out(unit);
        }
    }
}
