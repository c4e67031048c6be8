//! What a request shows to be admitted, and the forms of answers that all routes share.

use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use axum::routing::MethodRouter;
use serde::Serialize;

use super::access::{Access, Pass, Role};
use super::shared::Console;

/// A path and what answers there.
pub(super) type Route = (&'static str, MethodRouter<Arc<Console>>);

/// What the token or the cookie of a request permits; an answer with 401 where it permits nothing.
pub(super) fn may_enter(access: &Access, headers: &HeaderMap) -> Result<Role, Box<Response>> {
    pass_of(access, headers).map(|pass| pass.role)
}

/// The same of a request that needs the control; an answer with 403 to who may only watch.
pub(super) fn may_control(access: &Access, headers: &HeaderMap) -> Result<Pass, Box<Response>> {
    let pass = pass_of(access, headers)?;
    if pass.role == Role::Control {
        return Ok(pass);
    }
    Err(Box::new((StatusCode::FORBIDDEN, "this link is for watching\n").into_response()))
}

/// The token or the cookie of a request; an answer with 401 where it permits nothing.
pub(super) fn pass_of(access: &Access, headers: &HeaderMap) -> Result<Pass, Box<Response>> {
    let pass = access.pass(text_of(headers, header::AUTHORIZATION), text_of(headers, header::COOKIE));
    pass.ok_or_else(refused)
}

/// What the token or the cookie of a request permits.
pub(super) fn role_shown(access: &Access, headers: &HeaderMap) -> Option<Role> {
    access.role(text_of(headers, header::AUTHORIZATION), text_of(headers, header::COOKIE))
}

/// The text of a header; `None` where it is missing, or no text.
pub(super) fn text_of(headers: &HeaderMap, name: impl header::AsHeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// The answer to a request that nothing is permitted to.
pub(super) fn refused() -> Box<Response> {
    let body = "a token is needed: open the link that the program printed, or send `Authorization: Bearer`\n";
    Box::new((StatusCode::UNAUTHORIZED, [(header::WWW_AUTHENTICATE, "Bearer")], body).into_response())
}

/// A value as JSON.
pub(super) fn json(value: &impl Serialize) -> Response {
    match serde_json::to_vec(value) {
        Ok(body) => ([(header::CONTENT_TYPE, "application/json")], Body::from(body)).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}
