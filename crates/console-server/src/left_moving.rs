//! What may still move after the end of the program, as the pages are told.

/// What may still move. By default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftMoving {
    /// The camera may be turning: its last zeros could not be sent.
    pub camera: bool,
    /// The boat may be under way: its last neutral commands could not be sent.
    pub boat: bool,
}

impl LeftMoving {
    /// Nothing is known: the program fails.
    pub(super) const NOT_KNOWN: Self = Self { camera: true, boat: true };

    /// The reason with which the connections are closed (`docs/api.md`).
    pub(super) const fn reason(self) -> &'static str {
        match (self.camera, self.boat) {
            (false, false) => "the program ends",
            (true, false) => "the program ends: the camera may be turning",
            (false, true) => "the program ends: the boat may be under way",
            (true, true) => "the program ends: the camera and the boat may be moving",
        }
    }
}
