//! STATUSTEXT (253): what an autopilot says in words, put together from its chunks.
//!
//! The text comes from the network: only printable characters pass, a text has at most
//! [`VehicleText::MAX_BYTES`], and between two heartbeats at most [`MAX_TEXTS`] texts pass. The texts of
//! debugging (severity 7) do not.

use barrelman_vocab::vehicle_text::VehicleText;
use mavlink::dialects::common::STATUSTEXT_DATA;

/// Largest number of texts between two heartbeats.
pub(super) const MAX_TEXTS: u32 = 4;
/// The severity of debugging.
const DEBUG: u8 = 7;

/// Puts texts together.
#[derive(Debug, Clone, Default)]
pub(super) struct StatusTexts {
    /// The text whose chunks arrive: its id, the number of the next chunk, and what is there.
    open: Option<(u16, u8, VehicleText)>,
    passed: u32,
}

impl StatusTexts {
    /// A heartbeat was heard: texts may pass again.
    pub(super) const fn on_heartbeat(&mut self) {
        self.passed = 0;
    }

    /// Takes a chunk. Passes the texts that are complete by it to `each`: also one whose rest got lost.
    pub(super) fn on_text(&mut self, chunk: &STATUSTEXT_DATA, mut each: impl FnMut(VehicleText)) {
        let (severity, id, sequence) = (chunk.severity as u8, chunk.id, chunk.chunk_seq);
        let bytes = chunk.text.as_ref();
        let end = bytes.iter().position(|byte| *byte == 0);
        let part = &bytes[..end.unwrap_or(bytes.len())];
        if let Some((open, next, mut text)) = self.open.take() {
            if open == id && next == sequence && id != 0 {
                text.push(part);
                return self.go_on(id, sequence, text, end.is_some(), each);
            }
            text.push(b"...");
            self.pass(text, &mut each);
        }
        let mut text = VehicleText::new(severity);
        if sequence != 0 {
            text.push(b"...");
        }
        text.push(part);
        self.go_on(id, sequence, text, end.is_some() || id == 0, each);
    }

    /// A chunk that does not fill its field, and a text without an id, end the text.
    fn go_on(
        &mut self,
        id: u16,
        sequence: u8,
        text: VehicleText,
        is_last: bool,
        mut each: impl FnMut(VehicleText),
    ) {
        match sequence.checked_add(1) {
            Some(next) if !is_last && !text.is_full() => self.open = Some((id, next, text)),
            _ => self.pass(text, &mut each),
        }
    }

    fn pass(&mut self, text: VehicleText, each: &mut impl FnMut(VehicleText)) {
        if text.severity() < DEBUG && !text.as_str().trim().is_empty() && self.passed < MAX_TEXTS {
            self.passed += 1;
            each(text);
        }
    }
}
