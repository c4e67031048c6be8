//! What the node reads is there in the API's own schema, with a type that fits.

use barrelman_console_server::api::api_document;
use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::Value;

use super::*;

/// What a reference of a schema stands for.
fn resolved<'a>(document: &'a Value, mut schema: &'a Value) -> &'a Value {
    while let Some(target) = schema.get("$ref").and_then(Value::as_str) {
        schema = document.pointer(target.trim_start_matches('#')).expect(target);
    }
    schema
}

/// The schema of the value where it is not `null`, and whether it may be.
fn without_null<'a>(document: &'a Value, schema: &'a Value) -> (&'a Value, bool) {
    let schema = resolved(document, schema);
    let Some(choices) = schema.get("anyOf").and_then(Value::as_array) else { return (schema, false) };
    let is_null = |choice: &&Value| choice.get("type").and_then(Value::as_str) == Some("null");
    let (nulls, others): (Vec<_>, Vec<_>) = choices.iter().partition(is_null);
    assert!(nulls.len() == 1 && others.len() == 1, "{schema}");
    (resolved(document, others[0]), true)
}

/// The types of a value, without `null`, and whether it may be `null`.
fn types(schema: &Value) -> (Vec<&str>, bool) {
    let all: Vec<&str> = match schema.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(some)) => some.iter().filter_map(Value::as_str).collect(),
        // Names of a list.
        _ if schema.get("oneOf").is_some() || schema.get("enum").is_some() => vec!["string"],
        _ => panic!("{schema}"),
    };
    (all.iter().copied().filter(|one| *one != "null").collect(), all.contains(&"null"))
}

/// What is read fits what is written.
fn check_fits((ours, read): (&Value, &Value), (theirs, written): (&Value, &Value), what: &str) {
    let ((read, takes_null), (written, has_null)) = (without_null(ours, read), without_null(theirs, written));
    let ((read_types, reads_null), (written_types, writes_null)) = (types(read), types(written));
    assert_eq!(read_types, written_types, "{what}");
    assert!(takes_null || reads_null || !(has_null || writes_null), "{what} may be null");
    if let (Some(read), Some(written)) = (read.get("items"), written.get("items")) {
        check_fits((ours, read), (theirs, written), &format!("{what}[]"));
    }
    for (name, field) in read.get("properties").and_then(Value::as_object).into_iter().flatten() {
        let what = format!("{what}.{name}");
        let written = written["properties"].get(name).unwrap_or_else(|| panic!("the API has no {what}"));
        check_fits((ours, field), (theirs, written), &what);
    }
}

fn check<T: JsonSchema>(name: &str) {
    let generator =
        SchemaSettings::draft2020_12().with(|settings| settings.definitions_path = "/$defs".into());
    let ours = generator.into_generator().into_root_schema_for::<T>().to_value();
    let theirs = api_document();
    let written = theirs.pointer(&format!("/components/schemas/{name}")).expect(name);
    check_fits((&ours, &ours), (&theirs, written), name);
}

#[test]
fn every_field_that_is_read_is_one_of_the_api() {
    check::<Snapshot>("StatusSnapshot");
    check::<Hello>("Hello");
    check::<Control>("ControlSeat");
    check::<Answer>("Answer");
}

#[test]
fn messages_are_told_apart_by_their_types() {
    let read = |text: &str| serde_json::from_str::<ServerMessage>(text).unwrap();
    assert!(matches!(read(r#"{"type":"events","events":[]}"#), ServerMessage::Other));
    assert!(matches!(read(r#"{"type":"pong","sent_ms":1.5,"now_ns":7,"sent":3}"#), ServerMessage::Pong(_)));
    let answer = read(r#"{"type":"answer","id":3,"answer":"refused","reason":"why"}"#);
    let ServerMessage::Answer(answer) = answer else { panic!("{answer:?}") };
    assert_eq!(answer, Answer { id: 3, answer: AnswerKind::Refused, reason: Some("why".to_owned()) });
    assert!(matches!(
        read(r#"{"type":"answer","id":3,"answer":"accepted"}"#),
        ServerMessage::Answer(Answer { reason: None, .. })
    ));
}
