//! The task of the WebSocket: its opening, then its messages.

use std::sync::Arc;

use barrelman_wire::http::Received;
use futures_util::StreamExt as _;
use hyper::header::{AUTHORIZATION, HeaderValue};
use tokio::sync::mpsc::Receiver;
use tokio::time::{Instant, timeout_at};
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{WebSocketStream, client_async_with_config};

use crate::authorization::Authorization;
use crate::connection::{Connector, Stream};
use crate::inbox::Inbox;
use crate::lane::Queued;

/// Largest message, bytes.
const MAX_MESSAGE_BYTES: usize = 64 << 10;
/// Bytes that wait for a vehicle that does not read, at most: answers to its pings. What is beyond ends the
/// WebSocket.
const MAX_UNSENT_BYTES: usize = 256 << 10;

/// Opens a WebSocket for each request, and passes its messages on until it ends.
pub(crate) async fn serve(connector: Connector, mut requests: Receiver<Queued>, inbox: Arc<Inbox>) {
    while let Some(queued) = requests.recv().await {
        let id = queued.id;
        if queued.is_overdue(Instant::now()) {
            inbox.put(Received::NoAnswer { id });
            continue;
        }
        match timeout_at(queued.deadline, open(&connector, &queued.asked.path)).await {
            Ok(Ok(socket)) => {
                inbox.put(Received::Answer { id, status: 101, body: Vec::new() });
                pass_on(socket, &inbox).await;
                inbox.put(Received::SocketEnded);
            }
            // The vehicle has no WebSocket there: it said so.
            Ok(Err(Error::Http(answer))) => {
                let status = answer.status().as_u16();
                inbox.put(Received::Answer { id, status, body: Vec::new() });
            }
            Ok(Err(_)) | Err(_) => inbox.put(Received::NoAnswer { id }),
        }
    }
}

async fn open(connector: &Connector, path: &str) -> Result<WebSocketStream<Box<dyn Stream>>, Error> {
    let stream = connector.connect().await?;
    // The scheme names no encryption here: the stream has it.
    let address = format!("ws://{}{}", connector.authority(), connector.path(path));
    let mut request = address.into_client_request()?;
    if let Authorization::Bearer(token) = connector.authorization() {
        let value = HeaderValue::from_str(&format!("Bearer {token}")).map_err(hyper::http::Error::from)?;
        request.headers_mut().insert(AUTHORIZATION, value);
    }
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE_BYTES))
        .max_frame_size(Some(MAX_MESSAGE_BYTES))
        .write_buffer_size(0)
        .max_write_buffer_size(MAX_UNSENT_BYTES);
    client_async_with_config(request, stream, Some(config)).await.map(|(socket, _)| socket)
}

async fn pass_on(mut socket: WebSocketStream<Box<dyn Stream>>, inbox: &Inbox) {
    while let Some(Ok(message)) = socket.next().await {
        match message {
            Message::Text(text) => inbox.put(Received::Message(text.as_bytes().to_vec())),
            Message::Binary(bytes) => inbox.put(Received::Message(bytes.to_vec())),
            Message::Close(_) => return,
            Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => {}
        }
    }
}
