//! STATUSTEXT (253): a refusal in words. A text of more than 50 bytes is sent in parts.

use mavlink::dialects::common::{MavSeverity, STATUSTEXT_DATA};
use mavlink::types::CharArray;

use crate::mavlink::frame::FrameWriter;

/// Bytes of one message.
const PART_BYTES: usize = 50;
/// Parts of a text; what is longer is cut.
const MAX_PARTS: usize = 5;

/// Appends the messages of a text. `id` is not 0, and differs from that of the text before.
pub(super) fn write(text: &str, id: u16, writer: &mut FrameWriter, out: &mut Vec<Vec<u8>>) {
    // A part must not end within a character.
    let plain: Vec<u8> = text.chars().map(|c| if c.is_ascii() { c as u8 } else { b'?' }).collect();
    let is_whole = plain.len() < PART_BYTES;
    for (part, bytes) in plain.chunks(PART_BYTES).take(MAX_PARTS).enumerate() {
        let mut text = [0; PART_BYTES];
        text[..bytes.len()].copy_from_slice(bytes);
        out.push(writer.write(&STATUSTEXT_DATA {
            severity: MavSeverity::MAV_SEVERITY_WARNING,
            text: CharArray::from(text),
            id: if is_whole { 0 } else { id },
            chunk_seq: part as u8,
        }));
    }
}
