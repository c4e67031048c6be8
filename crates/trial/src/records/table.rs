//! Any channel of a recording as a table: one row per message, one column per field.
//!
//! Fields of nested messages become columns such as `percept.p`, within the bounds of
//! [`columns`](super::columns); a message beyond the bounds becomes one column of JSON. Absent fields are
//! empty; bytes are represented by their length. The schemas come from the file, so that channels of later
//! versions can be read too; channels that are not protobuf are ignored.

use std::collections::BTreeMap;
use std::io::Read;
use std::rc::Rc;

use prost::Message as _;
use prost_reflect::prost_types::FileDescriptorSet;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor};

use super::columns::Columns;
use super::reader::{ReadError, is_truncation, messages};

/// A row of a channel's table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableRow {
    /// Topic of the row.
    pub topic: String,
    /// Names of the columns, equal for all rows of a topic.
    pub columns: Vec<String>,
    /// The cells, quoted where CSV needs it (RFC 4180).
    pub cells: Vec<String>,
    /// The columns that hold JSON, because the messages in them nest too deep, too widely or in their own
    /// kind; the same for every row of a topic.
    pub json_columns: Vec<String>,
}

/// Reads a recording row by row; passes each row to `row`.
///
/// # Errors
/// The error of `row`, or [`ReadError`] where the recording cannot be read further, after the rows before.
pub fn read_rows<R: Read, E: From<ReadError>>(
    input: R,
    mut row: impl FnMut(TableRow) -> Result<(), E>,
) -> Result<(), E> {
    // By the schema's number: many channels may share one.
    let mut kinds: BTreeMap<u16, Rc<MessageKind>> = BTreeMap::new();
    for message in messages(input) {
        let message = message.map_err(|error| {
            if is_truncation(&error) { ReadError::Truncated } else { ReadError::Container(error) }
        })?;
        let topic = message.channel.topic.clone();
        let malformed = |reason: String| ReadError::Message { topic: topic.clone(), reason };
        let Some(schema) = &message.channel.schema else { continue };
        if schema.encoding != "protobuf" || message.channel.message_encoding != "protobuf" {
            continue;
        }
        let kind = match kinds.get(&schema.id) {
            Some(kind) => Rc::clone(kind),
            None => {
                let kind = MessageKind::new(&schema.name, &schema.data).map_err(malformed)?;
                Rc::clone(kinds.entry(schema.id).or_insert(Rc::new(kind)))
            }
        };
        let content = DynamicMessage::decode(kind.descriptor.clone(), message.data.as_ref())
            .map_err(|error| malformed(error.to_string()))?;
        let mut cells = vec![message.log_time.to_string()];
        cells.extend(kind.columns.cells(&content));
        let (columns, json_columns) = (kind.names.clone(), kind.json_columns.clone());
        row(TableRow { topic, columns, cells, json_columns })?;
    }
    Ok(())
}

/// A kind of message, and its columns.
struct MessageKind {
    descriptor: MessageDescriptor,
    columns: Columns,
    names: Vec<String>,
    json_columns: Vec<String>,
}

impl MessageKind {
    fn new(name: &str, schema: &[u8]) -> Result<Self, String> {
        let descriptor = message_descriptor(name, schema)?;
        let columns = Columns::new(descriptor.clone());
        let mut names = vec!["log_time_ns".to_owned()];
        names.extend(columns.names());
        Ok(Self { descriptor, names, json_columns: columns.json(), columns })
    }
}

/// The descriptor of a message in a schema.
fn message_descriptor(name: &str, schema: &[u8]) -> Result<MessageDescriptor, String> {
    let files = FileDescriptorSet::decode(schema).map_err(|error| error.to_string())?;
    for file in &files.file {
        // The pool panics at an unknown syntax.
        if !matches!(file.syntax(), "" | "proto2" | "proto3") {
            return Err(format!("its schema is written in the unknown syntax {:?}", file.syntax()));
        }
    }
    let pool = DescriptorPool::from_file_descriptor_set(files).map_err(|error| error.to_string())?;
    pool.get_message_by_name(name).ok_or_else(|| format!("its schema does not describe {name}"))
}
