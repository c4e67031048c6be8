//! The serialised form of the requests: one object, in which `kind` alone tells the enum.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use strum::VariantNames;

use super::{
    CameraRequest, NoteRequest, OperatorRequest, Request, SeatRequest, VesselRequest, VideoRequest,
    WorldRequest,
};
use crate::stop_cause::StopCause;

/// A stop.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
enum StopRequest {
    /// Rest the camera at once, until the next `engage`, and stop the vessel. The console takes it from
    /// watchers, too.
    Stop {
        /// The reason.
        #[serde(default)]
        cause: StopCause,
    },
}

impl Serialize for OperatorRequest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Stop(cause) => StopRequest::Stop { cause: *cause }.serialize(serializer),
            Self::Camera(request) => request.serialize(serializer),
            Self::Vessel(request) => request.serialize(serializer),
        }
    }
}

impl Serialize for Request {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Operator(request) => request.serialize(serializer),
            Self::World(request) => request.serialize(serializer),
            Self::Video(request) => request.serialize(serializer),
            Self::Note(request) => request.serialize(serializer),
            Self::Seat(request) => request.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for OperatorRequest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Request::deserialize(deserializer)? {
            Request::Operator(request) => Ok(request),
            Request::World(_) | Request::Video(_) | Request::Note(_) | Request::Seat(_) => {
                Err(Error::custom("the request is not for the pilot"))
            }
        }
    }
}

impl<'de> Deserialize<'de> for Request {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let kind = value.get("kind").and_then(Value::as_str);
        let kind = kind.ok_or_else(|| D::Error::missing_field("kind"))?;
        let has = |kinds: &[&str]| kinds.contains(&kind);
        Ok(if has(StopRequest::VARIANTS) {
            let StopRequest::Stop { cause } = read(value)?;
            Self::Operator(OperatorRequest::Stop(cause))
        } else if has(CameraRequest::VARIANTS) {
            Self::Operator(OperatorRequest::Camera(read(value)?))
        } else if has(VesselRequest::VARIANTS) {
            Self::Operator(OperatorRequest::Vessel(read(value)?))
        } else if has(WorldRequest::VARIANTS) {
            Self::World(read(value)?)
        } else if has(VideoRequest::VARIANTS) {
            Self::Video(read(value)?)
        } else if has(NoteRequest::VARIANTS) {
            Self::Note(read(value)?)
        } else if has(SeatRequest::VARIANTS) {
            Self::Seat(read(value)?)
        } else {
            return Err(Error::custom(format_args!(
                "there is no request of the kind `{kind}`: use one of {}",
                kinds().join(", ")
            )));
        })
    }
}

/// The kinds of all requests.
fn kinds() -> Vec<&'static str> {
    [
        StopRequest::VARIANTS,
        CameraRequest::VARIANTS,
        VesselRequest::VARIANTS,
        WorldRequest::VARIANTS,
        VideoRequest::VARIANTS,
        NoteRequest::VARIANTS,
        SeatRequest::VARIANTS,
    ]
    .concat()
}

/// Reads a request whose kind is known. A field that the request does not have is an error.
fn read<T: DeserializeOwned + Serialize, E: Error>(value: Value) -> Result<T, E> {
    let given: Vec<String> =
        value.as_object().map(|object| object.keys().cloned().collect()).unwrap_or_default();
    let request: T = serde_json::from_value(value).map_err(E::custom)?;
    let known = serde_json::to_value(&request).map_err(E::custom)?;
    match given.iter().find(|key| known.get(key).is_none()) {
        // Serde passes over the fields of a request that has none.
        Some(key) => Err(E::custom(format_args!("unknown field `{key}`"))),
        None => Ok(request),
    }
}

impl JsonSchema for Request {
    fn schema_name() -> Cow<'static, str> {
        "Request".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A request of a page or of another program. Refused with a reason, or accepted.",
            "oneOf": [
                generator.subschema_for::<StopRequest>(),
                generator.subschema_for::<CameraRequest>(),
                generator.subschema_for::<VesselRequest>(),
                generator.subschema_for::<WorldRequest>(),
                generator.subschema_for::<VideoRequest>(),
                generator.subschema_for::<NoteRequest>(),
                generator.subschema_for::<SeatRequest>(),
            ],
        })
    }
}
