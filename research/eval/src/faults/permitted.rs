//! The last moment that permitted motion, as far as a guard could hear of it.

/// The last moment that permitted motion.
#[derive(Debug)]
pub(super) struct Permitted {
    has_live_guard: bool,
    heard_ms: Option<u64>,
    /// The newest moment while no guard carries out anything: it permits motion as soon as a guard does
    /// again.
    unheard_ms: Option<u64>,
}

impl Permitted {
    /// No moment yet, and a guard that is live.
    pub(super) const fn new() -> Self {
        Self { has_live_guard: true, heard_ms: None, unheard_ms: None }
    }

    /// Whether a guard carries out what the program asks for.
    pub(super) fn set_live_guard(&mut self, is_live: bool) {
        self.has_live_guard = is_live;
        if is_live {
            self.heard_ms = self.heard_ms.max(self.unheard_ms.take());
        }
    }

    /// A moment permits motion.
    pub(super) const fn permit(&mut self, at_ms: u64) {
        if self.has_live_guard {
            self.heard_ms = Some(at_ms);
        } else {
            self.unheard_ms = Some(at_ms);
        }
    }

    /// The last moment that a guard heard of.
    pub(super) const fn heard_ms(&self) -> Option<u64> {
        self.heard_ms
    }

    /// The last moment, heard or not.
    pub(super) fn newest_ms(&self) -> Option<u64> {
        self.heard_ms.max(self.unheard_ms)
    }
}
