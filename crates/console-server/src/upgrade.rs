//! The handshake of a WebSocket (RFC 6455, section 4.2). Not the framework's own, which passes the library's
//! socket on and not the bytes: their frames could not be counted.

use std::future::Future;

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

/// Answers a request for a socket, and passes the stream of bytes on once the answer is sent.
pub(super) fn upgrade<S, F>(mut request: Request, serve: S) -> Response
where
    S: FnOnce(TokioIo<Upgraded>) -> F + Send + 'static,
    F: Future<Output = ()> + Send + 'static,
{
    let Some(accept) = accept_key(request.headers()) else {
        let text =
            "send a WebSocket handshake: Connection, Upgrade, Sec-WebSocket-Version: 13, Sec-WebSocket-Key\n";
        return (StatusCode::BAD_REQUEST, text).into_response();
    };
    let upgraded = hyper::upgrade::on(&mut request);
    tokio::spawn(async move {
        // A connection that ends before its answer is sent concerns nobody else.
        if let Ok(upgraded) = upgraded.await {
            serve(TokioIo::new(upgraded)).await;
        }
    });
    let headers = [
        (header::CONNECTION, HeaderValue::from_static("upgrade")),
        (header::UPGRADE, HeaderValue::from_static("websocket")),
        (header::SEC_WEBSOCKET_ACCEPT, accept),
    ];
    (StatusCode::SWITCHING_PROTOCOLS, headers).into_response()
}

/// The answer to the key of a handshake; `None`: the request is none.
fn accept_key(headers: &HeaderMap) -> Option<HeaderValue> {
    let has = |name, word: &str| {
        let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
        values.flat_map(|value| value.split(',')).any(|found| found.trim().eq_ignore_ascii_case(word))
    };
    let is_handshake = has(header::CONNECTION, "upgrade")
        && has(header::UPGRADE, "websocket")
        && has(header::SEC_WEBSOCKET_VERSION, "13");
    let key = headers.get(header::SEC_WEBSOCKET_KEY).filter(|_| is_handshake)?;
    HeaderValue::from_str(&derive_accept_key(key.as_bytes())).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The answer to a handshake of these headers.
    fn accept(headers: &[(&'static str, &'static str)]) -> Option<HeaderValue> {
        let headers = headers
            .iter()
            .map(|(name, value)| (header::HeaderName::from_static(name), HeaderValue::from_static(value)));
        accept_key(&headers.collect())
    }

    #[test]
    fn the_key_of_a_handshake_is_answered_and_anything_else_is_none() {
        // The example of RFC 6455, section 1.3.
        let whole = [
            ("connection", "keep-alive, Upgrade"),
            ("upgrade", "WebSocket"),
            ("sec-websocket-version", "13"),
            ("sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ];
        assert_eq!(accept(&whole).unwrap(), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
        for absent in 0..whole.len() {
            let mut headers = whole.to_vec();
            headers.remove(absent);
            assert_eq!(accept(&headers), None, "without {}", whole[absent].0);
        }
        let other = [whole[0], whole[1], ("sec-websocket-version", "8"), whole[3]];
        assert_eq!(accept(&other), None);
    }
}
