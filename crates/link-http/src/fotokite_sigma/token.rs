//! The token that a Sigma gives for an API key.

use barrelman_wire::fotokite_sigma::call::Call;
use barrelman_wire::http::{HttpCall, Method};

use crate::connection::Asked;
use crate::inquiry::{Inquiry, reason};
use crate::settings::Credential;

/// How the token is named in the vehicle's list.
const TOKEN_NAME: &str = "Barrelman";

pub(super) fn token_for(inquiry: &Inquiry, key: &str) -> Result<String, String> {
    let body = serde_json::json!({
        "grant_type": "client_credentials", "client_secret": key, "scope": "read control",
        "token_name": TOKEN_NAME,
    });
    let asked = Asked {
        method: Method::Post,
        path: "/v1/auth/token/request".to_owned(),
        content_type: Call::CONTENT_TYPE,
        body: Some(body.to_string().into()),
    };
    let (status, body) = inquiry.ask(&asked).map_err(|error| reason(&error))?;
    let token = || {
        let body: serde_json::Value = serde_json::from_slice(&body).ok()?;
        let token = body.get("access_token")?.as_str()?.to_owned();
        Credential::parse(&token).is_ok().then_some(token)
    };
    match status {
        200 | 201 => token().ok_or_else(|| "the answer to the API key holds no token".to_owned()),
        401 => Err("the API key is not known (401): put the right one into the token file".to_owned()),
        403 => Err(
            "the API key gives no token for reading and control (403): permit both on the vehicle's tablet"
                .to_owned(),
        ),
        status => Err(format!("the vehicle gives no token (status {status})")),
    }
}
