//! A request as a program makes it: `POST /api/v1/requests`, on a line of its own, so that none waits behind
//! another.

use barrelman_vocab::Request;
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::client::conn::http1;
use hyper::header::{AUTHORIZATION, CONNECTION, CONTENT_TYPE, HOST};
use hyper::{Method, StatusCode};
use hyper_util::rt::TokioIo;

use super::api::Answer;
use super::line::Line;

const PATH: &str = "/api/v1/requests";
/// Largest body of an answer, bytes.
const MAX_BODY_BYTES: usize = 64 << 10;
/// Longest text of an error, characters.
const MAX_ERROR_CHARS: usize = 300;

/// Makes a request and waits for its answer.
///
/// # Errors
/// Why there is no answer, in words.
pub async fn post(line: &Line, request: &Request) -> Result<Answer, String> {
    let (status, body) = exchange(line, request).await.map_err(|error| format!("{}: {error}", line.url()))?;
    if status == StatusCode::OK {
        return serde_json::from_slice(&body)
            .map_err(|error| format!("{}: the answer cannot be read: {error}", line.url()));
    }
    let text: String = String::from_utf8_lossy(&body).chars().take(MAX_ERROR_CHARS).collect();
    Err(format!("{} answers {status}: {}", line.url(), text.trim()))
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

async fn exchange(line: &Line, request: &Request) -> Result<(StatusCode, Bytes), Failure> {
    let body = serde_json::to_vec(&serde_json::json!({ "request": request }))?;
    let mut head = hyper::Request::builder()
        .method(Method::POST)
        .uri(PATH)
        .header(HOST, line.authority())
        .header(CONTENT_TYPE, "application/json")
        .header(CONNECTION, "close");
    if let Some(value) = line.authorization() {
        head = head.header(AUTHORIZATION, value);
    }
    let request = head.body(Full::new(Bytes::from(body)))?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(line.open().await?)).await?;
    let answered = async {
        let answer = sender.send_request(request).await?;
        let status = answer.status();
        let body = Limited::new(answer.into_body(), MAX_BODY_BYTES).collect().await?.to_bytes();
        Ok((status, body))
    };
    // Both in one future: whoever gives the request up drops its line, too.
    tokio::pin!(answered, connection);
    tokio::select! {
        answer = &mut answered => answer,
        ended = &mut connection => match ended {
            // The last bytes may have come with the end.
            Ok(()) => answered.await,
            Err(error) => Err(error.into()),
        },
    }
}
