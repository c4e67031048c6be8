//! Tables of channels whose own schema nests without end, fans out, or has more fields than a table has
//! columns.

use crate::single_message::read_single_message;

use barrelman_trial::records::columns::{MAX_COLUMNS, MAX_DEPTH};
use barrelman_trial::records::table::TableRow;
use prost::Message as _;
use prost_reflect::prost_types::field_descriptor_proto::{Label, Type};
use prost_reflect::prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, MessageOptions,
};
use prost_reflect::{DescriptorPool, DynamicMessage, MapKey, Value};

fn number(name: &str, at: usize) -> FieldDescriptorProto {
    field(name, at, Type::Int32)
}

fn field(name: &str, at: usize, kind: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(at as i32),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        ..FieldDescriptorProto::default()
    }
}

fn nested(name: &str, at: usize, kind: &str) -> FieldDescriptorProto {
    FieldDescriptorProto { type_name: Some(format!(".deep.{kind}")), ..field(name, at, Type::Message) }
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto { name: Some(name.to_owned()), field, ..DescriptorProto::default() }
}

fn schema(messages: Vec<DescriptorProto>) -> FileDescriptorSet {
    let file = FileDescriptorProto {
        name: Some("deep.proto".to_owned()),
        package: Some("deep".to_owned()),
        message_type: messages,
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }
}

/// The rows of a recording with one message of the kind `deep.L0`.
fn row(schema: &FileDescriptorSet, fill: impl FnOnce(&mut DynamicMessage)) -> TableRow {
    let pool = DescriptorPool::from_file_descriptor_set(schema.clone()).unwrap();
    let mut content = DynamicMessage::new(pool.get_message_by_name("deep.L0").unwrap());
    fill(&mut content);
    let row = read_single_message("deep.L0", &schema.encode_to_vec(), "/deep", &content.encode_to_vec());
    assert_eq!(row.columns.len(), row.cells.len());
    assert!(row.columns.len() <= MAX_COLUMNS + 1, "{} columns", row.columns.len());
    for column in &row.json_columns {
        assert!(row.columns.contains(column), "{column}");
    }
    row
}

/// The JSON in a column.
fn json(row: &TableRow, column: &str) -> serde_json::Value {
    let index = row.columns.iter().position(|found| found == column).unwrap();
    let cell = &row.cells[index];
    let text = match cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')) {
        Some(quoted) => quoted.replace("\"\"", "\""),
        None => cell.clone(),
    };
    serde_json::from_str(&text).unwrap()
}

/// Messages `L0` to `L<depth>`, each with a number field and fields of the next message.
fn fan(depth: usize, width: usize) -> FileDescriptorSet {
    let level = |at: usize| {
        let mut fields = vec![number("n", 1)];
        if at < depth {
            let next = format!("L{}", at + 1);
            fields.extend((0..width).map(|index| nested(&format!("c{index}"), index + 2, &next)));
        }
        message(&format!("L{at}"), fields)
    };
    schema((0..=depth).map(level).collect())
}

/// Sets the number of the message that lies so deep in the first field of each.
fn set_deep(content: &mut DynamicMessage, depth: usize, value: i32) {
    if depth == 0 {
        content.set_field_by_name("n", Value::I32(value));
        return;
    }
    let Some(Value::Message(inner)) = content.get_field_by_name_mut("c0") else { panic!("no c0") };
    set_deep(inner, depth - 1, value);
}

#[test]
fn a_schema_that_fans_out_is_given_as_json_beyond_its_bounds() {
    // 2^40 columns, if each field had its own.
    let deep = row(&fan(40, 2), |content| set_deep(content, 20, 5));
    let first = ["c0"; MAX_DEPTH].join(".");
    assert!(deep.json_columns.contains(&first), "{:?}", deep.json_columns);
    let mut found = json(&deep, &first);
    for _ in 0..20 - MAX_DEPTH {
        found = found["c0"].take();
    }
    assert_eq!(found["n"], 5);
    // Four levels of ten: the nearer ones get their columns.
    let wide = row(&fan(4, 10), |content| set_deep(content, 4, 6));
    assert!(wide.columns.len() > MAX_COLUMNS - 20, "{} columns", wide.columns.len());
    for column in ["n", "c9.n", "c0.c9.n"] {
        assert!(wide.columns.iter().any(|found| found == column), "{column}");
    }
    assert_eq!(json(&wide, "c0.c0.c0")["c0"]["n"], 6);
    assert!(wide.json_columns.contains(&"c9.c9".to_owned()), "{:?}", wide.json_columns);
}

#[test]
fn messages_that_nest_each_other_end() {
    // Each of twelve kinds holds every other: 12! paths that never come back to their own kind.
    let kinds = 12;
    let kind = |at: usize| {
        let others = (0..kinds).map(|other| nested(&format!("c{other}"), other + 2, &format!("L{other}")));
        message(&format!("L{at}"), [vec![number("n", 1)], others.collect()].concat())
    };
    let row = row(&schema((0..kinds).map(kind).collect()), |content| set_deep(content, 1, 7));
    assert!(row.columns.len() > kinds, "{} columns", row.columns.len());
    // The first field is of the message's own kind.
    assert!(row.json_columns.contains(&"c0".to_owned()));
    assert_eq!(json(&row, "c0"), serde_json::json!({"n": 7}));
}

#[test]
fn a_message_with_more_fields_than_columns_is_one_column() {
    let fields = (1..=MAX_COLUMNS + 1).map(|at| number(&format!("n{at}"), at)).collect();
    let row = row(&schema(vec![message("L0", fields)]), |content| {
        content.set_field_by_name("n7", Value::I32(-3));
    });
    assert_eq!(row.columns, ["log_time_ns", "message"]);
    assert_eq!(row.json_columns, ["message"]);
    assert_eq!(json(&row, "message"), serde_json::json!({"n7": -3}));
}

#[test]
fn names_that_grow_with_their_depth_are_bounded() {
    let long = "x".repeat(60_000);
    let level = |at: usize| {
        let next = format!("L{}", at + 1);
        message(&format!("L{at}"), vec![nested(&long, 1, &next), number("n", 2)])
    };
    let mut levels: Vec<DescriptorProto> = (0..7).map(level).collect();
    levels.push(message("L7", vec![number("n", 1)]));
    let row = row(&schema(levels), |_| {});
    let bytes: usize = row.columns.iter().map(String::len).sum();
    assert!(bytes < 300_000, "{bytes} bytes of names");
    assert_eq!(row.json_columns.len(), 1);
}

#[test]
fn json_holds_every_kind_of_value() {
    let repeated =
        |field: FieldDescriptorProto| FieldDescriptorProto { label: Some(Label::Repeated.into()), ..field };
    let entry = DescriptorProto {
        options: Some(MessageOptions { map_entry: Some(true), ..MessageOptions::default() }),
        ..message("ByNameEntry", vec![field("key", 1, Type::String), number("value", 2)])
    };
    let kinds = message(
        "L0",
        vec![
            nested("self", 1, "L0"),
            field("text", 2, Type::String),
            field("real", 3, Type::Double),
            field("data", 4, Type::Bytes),
            repeated(number("list", 5)),
            repeated(nested("by_name", 6, "L0.ByNameEntry")),
            field("big", 7, Type::Uint64),
            repeated(nested("more", 8, "L0")),
        ],
    );
    let schema = schema(vec![DescriptorProto { nested_type: vec![entry], ..kinds }]);
    let row = row(&schema, |content| {
        let mut inner = content.clone();
        let leaf = Value::Message(inner.clone());
        inner.set_field_by_name("text", Value::String("say \"aye\", \\\n\u{1}é".to_owned()));
        inner.set_field_by_name("real", Value::F64(f64::NAN));
        inner.set_field_by_name("data", Value::Bytes(vec![1, 2, 3].into()));
        inner.set_field_by_name("list", Value::List(vec![Value::I32(1), Value::I32(-2)]));
        let entries = [("b", 2), ("a", 1)].map(|(key, n)| (MapKey::String(key.to_owned()), Value::I32(n)));
        inner.set_field_by_name("by_name", Value::Map(entries.into()));
        inner.set_field_by_name("big", Value::U64(u64::MAX));
        inner.set_field_by_name("more", Value::List(vec![leaf.clone(), leaf]));
        content.set_field_by_name("self", Value::Message(inner));
    });
    assert_eq!(row.json_columns, ["self"]);
    assert_eq!(
        json(&row, "self"),
        serde_json::json!({
            "text": "say \"aye\", \\\n\u{1}é",
            "real": "NaN",
            "data": 3,
            "list": [1, -2],
            "by_name": {"a": 1, "b": 2},
            "big": u64::MAX,
            "more": [{}, {}],
        })
    );
}

#[test]
fn json_that_is_too_long_says_so() {
    let kinds = message("L0", vec![nested("self", 1, "L0"), field("text", 2, Type::String)]);
    let row = row(&schema(vec![kinds]), |content| {
        let mut inner = content.clone();
        inner.set_field_by_name("text", Value::String("x".repeat(2 << 20)));
        content.set_field_by_name("self", Value::Message(inner));
    });
    assert_eq!(json(&row, "self"), "longer than 1048576 bytes");
}
