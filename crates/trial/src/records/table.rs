//! Any channel of a recording as a table: one row per message, one column per field.
//!
//! Fields of nested messages become columns such as `percept.p`; a message nested in its own type becomes one empty
//! column. Absent fields are empty; bytes are represented by their length. The schemas come from the file, so that
//! channels of later versions can be read too; channels that are not protobuf are ignored.

use std::collections::BTreeMap;
use std::io::Read;

use prost::Message as _;
use prost_reflect::prost_types::FileDescriptorSet;
use prost_reflect::{DescriptorPool, DynamicMessage, FieldDescriptor, Kind, MessageDescriptor, Value};

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
}

/// Reads a recording row by row; passes each row to `row`.
///
/// # Errors
/// The error of `row`, or [`ReadError`] where the recording cannot be read further, after the rows before.
pub fn read_rows<R: Read, E: From<ReadError>>(
    input: R,
    mut row: impl FnMut(TableRow) -> Result<(), E>,
) -> Result<(), E> {
    let mut descriptors: BTreeMap<u16, MessageDescriptor> = BTreeMap::new();
    for message in messages(input) {
        let message = message.map_err(|error| {
            if is_truncation(&error) { ReadError::Truncated } else { ReadError::Container(error) }
        })?;
        let topic = message.channel.topic.clone();
        let malformed = |reason: String| ReadError::Message { topic: topic.clone(), reason };
        let descriptor = match descriptors.get(&message.channel.id) {
            Some(descriptor) => descriptor.clone(),
            None => {
                let Some(schema) = &message.channel.schema else { continue };
                if schema.encoding != "protobuf" || message.channel.message_encoding != "protobuf" {
                    continue;
                }
                let descriptor = message_descriptor(&schema.name, &schema.data).map_err(malformed)?;
                descriptors.entry(message.channel.id).or_insert(descriptor).clone()
            }
        };
        let content = DynamicMessage::decode(descriptor.clone(), message.data.as_ref())
            .map_err(|error| malformed(error.to_string()))?;
        let mut flat = FlattenedMessage::default();
        flat.columns.push("log_time_ns".to_owned());
        flat.cells.push(message.log_time.to_string());
        flat.add("", &descriptor, Some(&content));
        row(TableRow { topic, columns: flat.columns, cells: flat.cells })?;
    }
    Ok(())
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

/// The columns and cells of one message.
#[derive(Default)]
struct FlattenedMessage {
    columns: Vec<String>,
    cells: Vec<String>,
    /// Types of the message at hand and of those around it. A message nested in its own type is not flattened: its
    /// columns would be infinite.
    ancestors: Vec<MessageDescriptor>,
}

impl FlattenedMessage {
    fn add(&mut self, prefix: &str, descriptor: &MessageDescriptor, content: Option<&DynamicMessage>) {
        self.ancestors.push(descriptor.clone());
        for field in descriptor.fields() {
            let name = format!("{prefix}{}", field.name());
            let present = content.filter(|content| !field.supports_presence() || content.has_field(&field));
            match field.kind() {
                Kind::Message(nested)
                    if !field.is_list() && !field.is_map() && !self.ancestors.contains(&nested) =>
                {
                    let value = present.map(|content| content.get_field(&field).into_owned());
                    self.add(&format!("{name}."), &nested, value.as_ref().and_then(Value::as_message));
                }
                _ => {
                    let text = present.map(|content| format_cell(&field, &content.get_field(&field)));
                    self.columns.push(name);
                    self.cells.push(text.unwrap_or_default());
                }
            }
        }
        self.ancestors.pop();
    }
}

fn format_cell(field: &FieldDescriptor, value: &Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::I32(value) => value.to_string(),
        Value::I64(value) => value.to_string(),
        Value::U32(value) => value.to_string(),
        Value::U64(value) => value.to_string(),
        Value::F32(value) => value.to_string(),
        Value::F64(value) => value.to_string(),
        Value::String(text) => quote_csv(text),
        Value::Bytes(bytes) => bytes.len().to_string(),
        Value::EnumNumber(number) => match field.kind() {
            Kind::Enum(kind) => {
                kind.get_value(*number).map_or_else(|| number.to_string(), |value| value.name().to_owned())
            }
            _ => number.to_string(),
        },
        Value::List(items) => items.len().to_string(),
        Value::Map(entries) => entries.len().to_string(),
        Value::Message(_) => String::new(),
    }
}

/// Text as a CSV cell: quoted where it contains a comma, a quote or a line end (RFC 4180).
fn quote_csv(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
