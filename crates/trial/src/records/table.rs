//! Any channel of a recording as a table: one row per message, one column per field.
//!
//! Nested messages become columns like `percept.p`, as far as the bounds in [`columns`](super::columns) go, and one column
//! of JSON beyond them; absent fields are empty; bytes are shown by their length, since the video is exported as video. It
//! goes by the schemas in the file, so that it also knows channels of later versions; channels that are not protobuf are
//! passed over.

use std::collections::BTreeMap;
use std::io::Read;
use std::rc::Rc;

use prost::Message as _;
use prost_reflect::prost_types::FileDescriptorSet;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor};

use super::columns::Columns;
use super::reader::{ReadError, is_cut, messages};

/// A row of a channel's table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableRow {
    /// The topic that the row belongs to.
    pub topic: String,
    /// The columns' names; the same for every row of a topic.
    pub columns: Vec<String>,
    /// The cells, as text that is safe in a CSV.
    pub cells: Vec<String>,
    /// The columns that hold JSON, because the messages in them nest too deep, too widely or in their own kind; the same
    /// for every row of a topic.
    pub json_columns: Vec<String>,
}

/// Reads a recording row by row.
///
/// # Errors
/// Whatever `row` returns, and [`ReadError`] where the recording cannot be read on; the rows before were handed
/// out.
pub fn read_rows<R: Read, E: From<ReadError>>(
    input: R,
    mut row: impl FnMut(TableRow) -> Result<(), E>,
) -> Result<(), E> {
    // By the schema's number: many channels may share one.
    let mut kinds: BTreeMap<u16, Rc<MessageKind>> = BTreeMap::new();
    for message in messages(input) {
        let message = message
            .map_err(|error| if is_cut(&error) { ReadError::CutOff } else { ReadError::Container(error) })?;
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
        let descriptor = described(name, schema)?;
        let columns = Columns::new(descriptor.clone());
        let mut names = vec!["log_time_ns".to_owned()];
        names.extend(columns.names());
        Ok(Self { descriptor, names, json_columns: columns.json(), columns })
    }
}

/// The message of that name in a schema.
fn described(name: &str, schema: &[u8]) -> Result<MessageDescriptor, String> {
    let files = FileDescriptorSet::decode(schema).map_err(|error| error.to_string())?;
    for file in &files.file {
        // The pool panics at a syntax that it does not know.
        if !matches!(file.syntax(), "" | "proto2" | "proto3") {
            return Err(format!(
                "its schema is written in the syntax {:?}, which is not known here",
                file.syntax()
            ));
        }
    }
    let pool = DescriptorPool::from_file_descriptor_set(files).map_err(|error| error.to_string())?;
    pool.get_message_by_name(name).ok_or_else(|| format!("its schema does not describe {name}"))
}
