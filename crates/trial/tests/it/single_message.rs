//! A recording of one message on one channel, read back as rows.

use std::collections::BTreeMap;
use std::io::Cursor;

use barrelman_trial::records::ReadError;
use barrelman_trial::records::table::{TableRow, read_rows};
use mcap::records::MessageHeader;

/// Writes a message with the name and the descriptor set of its type to `topic` at 8 ns, and reads its only
/// row.
pub(crate) fn read_single_message(name: &str, schema: &[u8], topic: &str, message: &[u8]) -> TableRow {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut bytes).unwrap();
    let schema = writer.add_schema(name, "protobuf", schema).unwrap();
    let channel_id = writer.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap();
    let header = MessageHeader { channel_id, sequence: 0, log_time: 8, publish_time: 8 };
    writer.write_to_known_channel(&header, message).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let mut rows: Vec<TableRow> = Vec::new();
    read_rows(bytes.into_inner().as_slice(), |row| -> Result<(), ReadError> {
        rows.push(row);
        Ok(())
    })
    .unwrap();
    assert_eq!(rows.len(), 1);
    rows.remove(0)
}
