//! The OpenAPI document of the API, with the JSON Schemas generated from its types.

use schemars::{SchemaGenerator, generate::SchemaSettings};
use serde_json::{Value, json};

use super::paths::{paths, reference};
use super::{ClientMessage, ServerMessage};

/// The OpenAPI 3.1 document. OpenAPI has no WebSockets: the schemas of the socket's messages are those of
/// `components.schemas`, named in the description of the socket.
pub fn api_document() -> Value {
    let mut sent = generator(true);
    let mut taken = generator(false);
    let paths = paths(&mut sent, &mut taken);
    let to_page = reference::<ServerMessage>(&mut sent);
    let to_program = reference::<ClientMessage>(&mut taken);
    let mut schemas = sent.take_definitions(true);
    schemas.extend(taken.take_definitions(true));
    schemas.insert("MessageToPage".to_owned(), to_page);
    schemas.insert("MessageToProgram".to_owned(), to_program);
    json!({
        "openapi": "3.1.0",
        "info": {"title": "Barrelman", "version": env!("CARGO_PKG_VERSION")},
        "security": [{"token": []}, {}],
        "paths": paths,
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
            "schemas": schemas,
        },
    })
}

/// `is_sent`: the program writes the values, and does not read them.
fn generator(is_sent: bool) -> SchemaGenerator {
    let settings = SchemaSettings::draft2020_12()
        .with(|settings| settings.definitions_path = "/components/schemas".into());
    let settings = if is_sent { settings.for_serialize() } else { settings };
    settings.into_generator()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All references in a document.
    fn references(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(members) => {
                for (name, member) in members {
                    match member {
                        Value::String(target) if name == "$ref" => found.push(target.clone()),
                        _ => references(member, found),
                    }
                }
            }
            Value::Array(items) => items.iter().for_each(|item| references(item, found)),
            _ => {}
        }
    }

    #[test]
    fn every_reference_leads_to_a_schema() {
        let document = api_document();
        let mut found = Vec::new();
        references(&document, &mut found);
        assert!(found.len() > 20, "{found:?}");
        for target in found {
            let place = target.strip_prefix('#').unwrap_or_default();
            assert!(document.pointer(place).is_some(), "{target}");
        }
    }
}
