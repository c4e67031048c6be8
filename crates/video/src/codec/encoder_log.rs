//! Keeps the H.264 encoder from printing to stderr.
//!
//! The encoder prints warnings (for instance about the setting not to skip pictures) during its setup at the
//! first picture. The binding's switch takes effect only after the setup. Therefore this module sets the
//! option on the encoder before its setup, which the encoder allows for this option.

#![allow(unsafe_code, reason = "the binding offers this option only through its raw interface")]

use openh264::encoder::Encoder;
use openh264_sys2::{ENCODER_OPTION_TRACE_LEVEL, WELS_LOG_QUIET};

/// Disables all log output of an encoder.
pub(super) fn silence(encoder: &mut Encoder) {
    let mut level = WELS_LOG_QUIET;
    // SAFETY: the encoder lives, the option takes a pointer to an int, which it reads before it returns
    // (codec_app_def.h, ENCODER_OPTION_TRACE_LEVEL), and the binding relies on no other value of it.
    // A refusal would only leave the warnings on.
    unsafe {
        encoder.raw_api().set_option(ENCODER_OPTION_TRACE_LEVEL, (&raw mut level).cast());
    }
}
