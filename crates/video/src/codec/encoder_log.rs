//! Keeps the H.264 encoder from printing to stderr.
//!
//! The encoder prints its warnings (about our choice not to leave out pictures, for one) while it is set up at
//! the first picture, and the binding's own switch comes into force only after that. So the option is set here,
//! on an encoder that is made but not yet set up, which the encoder allows for this option.

#![allow(unsafe_code, reason = "the binding offers this option only through its raw interface")]

use openh264::encoder::Encoder;
use openh264_sys2::{ENCODER_OPTION_TRACE_LEVEL, WELS_LOG_QUIET};

/// Makes an encoder silent for good.
pub(super) fn silence(encoder: &mut Encoder) {
    let mut level = WELS_LOG_QUIET;
    // SAFETY: the encoder lives, the option takes a pointer to an int, which it reads before it returns
    // (codec_app_def.h, ENCODER_OPTION_TRACE_LEVEL), and the binding relies on no other value of it.
    // A refusal would leave the warnings on, and nothing else.
    unsafe {
        encoder.raw_api().set_option(ENCODER_OPTION_TRACE_LEVEL, (&raw mut level).cast());
    }
}
