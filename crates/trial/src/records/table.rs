//! Any channel of a recording as a table: one row per message, one column per field.
//!
//! Nested messages become columns like `percept.p` (one that lies in its own kind an empty column); absent fields are empty; bytes are shown by their length,
//! since the video is exported as video. It goes by the schemas in the file, so that it also knows channels of
//! later versions; channels that are not protobuf are passed over.

use std::collections::BTreeMap;
use std::io::Read;

use prost::Message as _;
use prost_reflect::prost_types::FileDescriptorSet;
use prost_reflect::{DescriptorPool, DynamicMessage, FieldDescriptor, Kind, MessageDescriptor, Value};

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
    let mut descriptors: BTreeMap<u16, MessageDescriptor> = BTreeMap::new();
    for message in messages(input) {
        let message = message
            .map_err(|error| if is_cut(&error) { ReadError::CutOff } else { ReadError::Container(error) })?;
        let topic = message.channel.topic.clone();
        let malformed = |reason: String| ReadError::Message { topic: topic.clone(), reason };
        let descriptor = match descriptors.get(&message.channel.id) {
            Some(descriptor) => descriptor.clone(),
            None => {
                let Some(schema) = &message.channel.schema else { continue };
                if schema.encoding != "protobuf" || message.channel.message_encoding != "protobuf" {
                    continue;
                }
                let descriptor = described(&schema.name, &schema.data).map_err(malformed)?;
                descriptors.entry(message.channel.id).or_insert(descriptor).clone()
            }
        };
        let content = DynamicMessage::decode(descriptor.clone(), message.data.as_ref())
            .map_err(|error| malformed(error.to_string()))?;
        let mut flat = Flat::default();
        flat.columns.push("log_time_ns".to_owned());
        flat.cells.push(message.log_time.to_string());
        flat.add("", &descriptor, Some(&content));
        row(TableRow { topic, columns: flat.columns, cells: flat.cells })?;
    }
    Ok(())
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

/// The columns and cells of one message, as they are collected.
#[derive(Default)]
struct Flat {
    columns: Vec<String>,
    cells: Vec<String>,
    /// The messages that the one at hand lies in: one that lies in its own kind would have columns without end.
    within: Vec<MessageDescriptor>,
}

impl Flat {
    fn add(&mut self, prefix: &str, descriptor: &MessageDescriptor, content: Option<&DynamicMessage>) {
        self.within.push(descriptor.clone());
        for field in descriptor.fields() {
            let name = format!("{prefix}{}", field.name());
            let present = content.filter(|content| !field.supports_presence() || content.has_field(&field));
            match field.kind() {
                Kind::Message(nested)
                    if !field.is_list() && !field.is_map() && !self.within.contains(&nested) =>
                {
                    let value = present.map(|content| content.get_field(&field).into_owned());
                    self.add(&format!("{name}."), &nested, value.as_ref().and_then(Value::as_message));
                }
                _ => {
                    let text = present.map(|content| cell(&field, &content.get_field(&field)));
                    self.columns.push(name);
                    self.cells.push(text.unwrap_or_default());
                }
            }
        }
        self.within.pop();
    }
}

fn cell(field: &FieldDescriptor, value: &Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::I32(value) => value.to_string(),
        Value::I64(value) => value.to_string(),
        Value::U32(value) => value.to_string(),
        Value::U64(value) => value.to_string(),
        Value::F32(value) => value.to_string(),
        Value::F64(value) => value.to_string(),
        Value::String(text) => quoted(text),
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

/// Text as a CSV cell: quoted where it holds a comma, a quote or a line end (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
