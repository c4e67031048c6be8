//! The decoder: units of one stream to pictures.
//!
//! ```text
//!  channel -> push -> parser -> decoder -> videoconvert -> videoscale -> capsfilter -> Output -> channel
//!             \______________________ one thread, one call ______________________________/
//! ```
//! [`line::Line`] has no queue: pushing a unit into the parser runs the whole line, down to the message with
//! the picture. So every picture that is ready is sent before the `Done` of its unit, without waiting and
//! without a clock. (A hardware decoder may deliver from a thread of its own, later.)
//!
//! Only intact pictures are delivered: after damage, and at the start, all units up to the next key are
//! skipped.
//!
//! Not handled: streams without key frames (periodic intra refresh), which never start; bit errors that leave
//! a picture readable, which no decoder notices; a hardware decoder that starts but cannot decode this
//! stream.

mod choice;

mod line;

mod output;

mod deinterlacing;

mod damage;

use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::decoder::{DecoderElement, DecoderList, FromDecoder, ToDecoder};
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::DecoderSettings;
use gst::prelude::*;
use gstreamer as gst;

use crate::rights::{self, Kept};
use line::Line;

/// How long one wait for a message lasts. Nothing happens between two waits.
const WAIT: Duration = Duration::from_secs(3600);

/// Decodes until the channel is closed.
pub(crate) fn serve(mut channel: Channel, settings: DecoderSettings) -> Result<(), ChannelError> {
    let line = match Line::new(settings, channel.try_clone().map_err(ChannelError::Io)?) {
        Ok(line) => line,
        Err(none) => return refuse(&mut channel, &none.reason, &none.remedy),
    };
    rights::give_up(&Kept::default());
    let mut line = match line.started() {
        Ok(line) => line,
        Err(none) => return refuse(&mut channel, &none.reason, &none.remedy),
    };
    channel.send(&line.ready(), &[])?;
    loop {
        let Some((message, length)) = channel.receive::<ToDecoder>(Instant::now() + WAIT)? else { continue };
        let mut payload = vec![0; length];
        channel.read_payload(&mut payload)?;
        let damage = match message {
            ToDecoder::Decode { pts_ns, key } => line.decode(payload, pts_ns, key),
            ToDecoder::Flush => {
                line.flush();
                None
            }
        };
        line.output().finish(damage)?;
    }
}

/// Says why there is no decoder.
pub(crate) fn refuse(channel: &mut Channel, reason: &str, remedy: &str) -> Result<(), ChannelError> {
    let message = FromDecoder::NoDecoder { reason: reason.to_owned(), remedy: remedy.to_owned() };
    channel.send(&message, &[])
}

/// Lists the decoder of each format.
pub(crate) fn list(channel: &mut Channel) -> Result<(), ChannelError> {
    let started = gst::init().is_ok();
    let decoder = |format| {
        let (opened, element) = started.then(|| choice::decoder(format)).flatten()?;
        let _ = opened.set_state(gst::State::Null);
        Some(element)
    };
    let decoders: Vec<(CodedFormat, Option<DecoderElement>)> =
        CodedFormat::ALL.map(|format| (format, decoder(format))).into();
    let (major, minor, micro, _) = gst::version();
    channel.send(&DecoderList { version: format!("{major}.{minor}.{micro}"), decoders }, &[])
}
