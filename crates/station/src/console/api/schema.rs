//! The JSON Schemas of the API, generated from its types.

use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::{Value, json};

use super::{Answer, ClientMessage, RequestBody, ServerMessage, StatusSnapshot};

/// The schemas by the place where each is used.
pub fn api_schemas() -> Value {
    json!({
        "GET /api/v1/status, response": schema_of::<StatusSnapshot>(true),
        "POST /api/v1/requests, body": schema_of::<RequestBody>(false),
        "POST /api/v1/requests, response": schema_of::<Answer>(true),
        "/api/v1/socket, text to the program": schema_of::<ClientMessage>(false),
        "/api/v1/socket, text from the program": schema_of::<ServerMessage>(true),
    })
}

/// `is_sent`: the program writes the value, and does not read it.
fn schema_of<T: JsonSchema>(is_sent: bool) -> Value {
    let settings = SchemaSettings::draft2020_12();
    let settings = if is_sent { settings.for_serialize() } else { settings };
    settings.into_generator().into_root_schema_for::<T>().to_value()
}
