//! Damage that the decoders of libav tell in their log only.
//!
//! These decoders conceal what they cannot decode and deliver the picture as if it were intact. Their log
//! says so at once, in the same call. Only the lines that tell of damage to the picture count: streams of
//! many cameras break the standard in ways that cost no picture, and the log says that as well.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gstreamer as gst;

/// GStreamer's log category of libav.
const CATEGORY: &str = "libav";

/// Parts of the lines that tell of damage (libavcodec's h264_slice.c, h264_cavlc.c, h264_cabac.c,
/// h264_refs.c, hevc_refs.c, hevcdec.c, error_resilience.c).
const DAMAGE: &[&str] = &[
    "error while decoding MB",
    "concealing",
    "Missing reference picture",
    "reference picture missing",
    "Could not find ref with POC",
    "entry_point_offset table is corrupted",
    "Error allocating frame",
    "Overread",
];

/// The errors of libav since the last unit.
#[derive(Debug, Default)]
pub(super) struct LibavErrors {
    first: Mutex<Option<String>>,
}

impl LibavErrors {
    /// Takes GStreamer's log over: nothing is printed.
    pub(super) fn watch() -> Arc<Self> {
        let errors = Arc::new(Self::default());
        let watching = errors.clone();
        gst::log::remove_default_log_function();
        gst::log::set_threshold_for_name(CATEGORY, gst::DebugLevel::Error);
        gst::log::set_active(true);
        gst::log::add_log_function(move |category, _, _, _, _, _, message| {
            if category.name() == CATEGORY
                && let Some(line) = message.get()
            {
                watching.on_line(line.trim());
            }
        });
        errors
    }

    fn on_line(&self, line: &str) {
        if DAMAGE.iter().any(|part| line.contains(part)) {
            self.lock().get_or_insert_with(|| line.to_owned());
        }
    }

    /// The first error that damages the picture.
    pub(super) fn first(&self) -> Option<String> {
        self.lock().clone()
    }

    pub(super) fn forget(&self) {
        *self.lock() = None;
    }

    fn lock(&self) -> MutexGuard<'_, Option<String>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lines_of_damage_count_and_the_first_one_stays() {
        let errors = LibavErrors::default();
        errors.on_line("co located POCs unavailable");
        assert_eq!(errors.first(), None);
        errors.on_line("error while decoding MB 16 9, bytestream -12");
        errors.on_line("concealing 3 DC, 3 AC, 3 MV errors in P frame");
        assert_eq!(errors.first().as_deref(), Some("error while decoding MB 16 9, bytestream -12"));
        errors.forget();
        assert_eq!(errors.first(), None);
    }
}
