//! Values of a message as the cells of a CSV: texts quoted, variants by name, bytes, lists and maps by their
//! length, nested messages as JSON.
//!
//! The JSON is that of protobuf (absent fields are left away, numbers that are not finite are texts), except
//! that fields keep their names from the schema, numbers of 64 bits stay numbers, and bytes are told by their
//! length, as in a cell.

use std::fmt::Write as _;

use prost_reflect::{DynamicMessage, FieldDescriptor, Kind, MapKey, Value};

use crate::csv_row::quoted;

/// Bytes of JSON in one cell. Of a longer text the cell says only that it is longer: half a text is no JSON.
pub(super) const MAX_JSON_BYTES: usize = 1 << 20;

/// The cell of a field that is present.
pub(super) fn render_cell(field: &FieldDescriptor, value: &Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::I32(value) => value.to_string(),
        Value::I64(value) => value.to_string(),
        Value::U32(value) => value.to_string(),
        Value::U64(value) => value.to_string(),
        Value::F32(value) => value.to_string(),
        Value::F64(value) => value.to_string(),
        Value::String(text) => quoted(text).into_owned(),
        Value::Bytes(bytes) => bytes.len().to_string(),
        Value::EnumNumber(number) => variant(&field.kind(), *number).unwrap_or_else(|| number.to_string()),
        Value::List(items) => items.len().to_string(),
        Value::Map(entries) => entries.len().to_string(),
        Value::Message(message) => json(message),
    }
}

/// The cell of a message, as JSON.
pub(super) fn json(message: &DynamicMessage) -> String {
    let mut json = Json::default();
    match json.message(message) {
        Ok(()) => quoted(&json.text).into_owned(),
        Err(TooLong) => quoted(&format!("\"longer than {MAX_JSON_BYTES} bytes\"")).into_owned(),
    }
}

/// The name of a variant; `None` where the schema has none for the number.
fn variant(kind: &Kind, number: i32) -> Option<String> {
    match kind {
        Kind::Enum(variants) => variants.get_value(number).map(|value| value.name().to_owned()),
        _ => None,
    }
}

struct TooLong;

/// JSON as it is written.
#[derive(Default)]
struct Json {
    text: String,
}

impl Json {
    fn push(&mut self, text: &str) -> Result<(), TooLong> {
        if self.text.len() + text.len() > MAX_JSON_BYTES {
            return Err(TooLong);
        }
        self.text.push_str(text);
        Ok(())
    }

    /// A message cannot nest deeper than the decoder goes, which is 100 levels.
    fn message(&mut self, message: &DynamicMessage) -> Result<(), TooLong> {
        self.push("{")?;
        for (index, (field, value)) in message.fields().enumerate() {
            self.separate(index)?;
            self.string(field.name())?;
            self.push(":")?;
            self.value(&field.kind(), value)?;
        }
        self.push("}")
    }

    fn value(&mut self, kind: &Kind, value: &Value) -> Result<(), TooLong> {
        match value {
            Value::Bool(value) => self.push(&value.to_string()),
            Value::I32(value) => self.push(&value.to_string()),
            Value::I64(value) => self.push(&value.to_string()),
            Value::U32(value) => self.push(&value.to_string()),
            Value::U64(value) => self.push(&value.to_string()),
            Value::F32(value) => self.float(f64::from(*value), &value.to_string()),
            Value::F64(value) => self.float(*value, &value.to_string()),
            Value::String(text) => self.string(text),
            Value::Bytes(bytes) => self.push(&bytes.len().to_string()),
            Value::EnumNumber(number) => match variant(kind, *number) {
                Some(name) => self.string(&name),
                None => self.push(&number.to_string()),
            },
            Value::Message(message) => self.message(message),
            Value::List(items) => {
                self.push("[")?;
                for (index, item) in items.iter().enumerate() {
                    self.separate(index)?;
                    self.value(kind, item)?;
                }
                self.push("]")
            }
            Value::Map(entries) => {
                let Kind::Message(entry) = kind else { return self.push("{}") };
                let kind = entry.map_entry_value_field().kind();
                // The entries have no order of their own.
                let mut entries: Vec<(String, &Value)> =
                    entries.iter().map(|(key, value)| (key_text(key), value)).collect();
                entries.sort_by(|a, b| a.0.cmp(&b.0));
                self.push("{")?;
                for (index, (key, value)) in entries.into_iter().enumerate() {
                    self.separate(index)?;
                    self.string(&key)?;
                    self.push(":")?;
                    self.value(&kind, value)?;
                }
                self.push("}")
            }
        }
    }

    fn separate(&mut self, index: usize) -> Result<(), TooLong> {
        if index > 0 { self.push(",") } else { Ok(()) }
    }

    fn float(&mut self, value: f64, text: &str) -> Result<(), TooLong> {
        match value {
            value if value.is_finite() => self.push(text),
            value if value.is_nan() => self.push("\"NaN\""),
            value if value > 0.0 => self.push("\"Infinity\""),
            _ => self.push("\"-Infinity\""),
        }
    }

    fn string(&mut self, text: &str) -> Result<(), TooLong> {
        self.push("\"")?;
        let mut escape = String::new();
        for character in text.chars() {
            escape.clear();
            match character {
                '"' => escape.push_str("\\\""),
                '\\' => escape.push_str("\\\\"),
                '\n' => escape.push_str("\\n"),
                '\r' => escape.push_str("\\r"),
                '\t' => escape.push_str("\\t"),
                control if control < ' ' => {
                    // Writing to a string cannot fail.
                    let _ = write!(escape, "\\u{:04x}", u32::from(control));
                }
                other => escape.push(other),
            }
            self.push(&escape)?;
        }
        self.push("\"")
    }
}

fn key_text(key: &MapKey) -> String {
    match key {
        MapKey::Bool(key) => key.to_string(),
        MapKey::I32(key) => key.to_string(),
        MapKey::I64(key) => key.to_string(),
        MapKey::U32(key) => key.to_string(),
        MapKey::U64(key) => key.to_string(),
        MapKey::String(key) => key.clone(),
    }
}
