//! The operator's requests, to and from their stored form: the JSON of [`barrelman_vocab::request`].

use barrelman_vocab::OperatorRequest;

use super::malformed::{Malformed, unreadable};
use crate::records::stored;

impl From<&OperatorRequest> for stored::RequestInput {
    fn from(request: &OperatorRequest) -> Self {
        let request = serde_json::to_string(request).expect("a request is plain data, which JSON can hold");
        Self { request, ..Self::default() }
    }
}

impl TryFrom<stored::RequestInput> for OperatorRequest {
    type Error = Malformed;

    fn try_from(message: stored::RequestInput) -> Result<Self, Malformed> {
        serde_json::from_str(&message.request).map_err(|error| unreadable("request", &error))
    }
}
