//! The task of a lane: one request after the other, each within the lane's time, on a connection of its own.

use std::sync::Arc;
use std::time::Duration;

use barrelman_wire::fotokite_sigma::Received;
use barrelman_wire::fotokite_sigma::call::{Lane, Method, Request};
use tokio::sync::mpsc::Receiver;

use crate::connection::{Asked, Connection, Connector};
use crate::inbox::Inbox;

/// Interval at which a connection at rest is looked at: a command must not wait for a new one.
const LOOK_INTERVAL: Duration = Duration::from_millis(500);

/// Serves a lane until there are no more requests.
pub(crate) async fn serve(
    lane: Lane,
    connector: Connector,
    token: Arc<str>,
    mut requests: Receiver<Request>,
    inbox: Arc<Inbox>,
) {
    let mut connection = Connection::open(&connector).await.ok();
    loop {
        let request = match tokio::time::timeout(LOOK_INTERVAL, requests.recv()).await {
            Ok(Some(request)) => request,
            Ok(None) => return,
            Err(_) => {
                if connection.as_ref().is_none_or(Connection::is_closed) {
                    connection = Connection::open(&connector).await.ok();
                }
                continue;
            }
        };
        let id = request.id;
        let answered = ask(&connector, &token, &mut connection, &request);
        match tokio::time::timeout(lane.timeout(), answered).await {
            Ok(Some((status, body))) => inbox.put(Received::Answer { id, status, body }),
            Ok(None) | Err(_) => {
                // What was sent on it may come late, and must not meet the next request.
                connection = None;
                inbox.put(Received::NoAnswer { id });
            }
        }
    }
}

/// Asks on the open connection, or on a new one. A connection that the vehicle had closed meanwhile is replaced once.
async fn ask(
    connector: &Connector,
    token: &str,
    connection: &mut Option<Connection>,
    request: &Request,
) -> Option<(u16, Vec<u8>)> {
    for _ in 0..2 {
        let is_new = connection.as_ref().is_none_or(Connection::is_closed);
        if is_new {
            *connection = Some(Connection::open(connector).await.ok()?);
        }
        let asked = Asked {
            method: match request.call.method() {
                Method::Get => hyper::Method::GET,
                Method::Post => hyper::Method::POST,
            },
            path: request.call.path(),
            body: request.call.body(),
        };
        match connection.as_mut()?.ask(connector, token, asked).await {
            Ok(answer) => return Some(answer),
            Err(_) if !is_new => *connection = None,
            Err(_) => return None,
        }
    }
    None
}
