//! The task of a lane: one request after the other, each within the lane's time, on a connection of its own.

use std::sync::Arc;
use std::time::Duration;

use barrelman_wire::fotokite_sigma::Received;
use barrelman_wire::fotokite_sigma::call::{Method, Request};
use tokio::sync::mpsc::Receiver;
use tokio::time::{Instant, timeout, timeout_at};

use crate::connection::{Asked, Connection, Connector};
use crate::inbox::Inbox;

/// Interval at which a connection at rest is looked at: a command must not wait for a new one.
const LOOK_INTERVAL: Duration = Duration::from_millis(500);

/// A request that waits in its lane. Its time begins when it is handed to the lane: connecting takes from it, too.
#[derive(Debug)]
pub(crate) struct Queued {
    pub(crate) request: Request,
    pub(crate) handed_over_at: Instant,
}

impl Queued {
    /// The end of the request's time. It must not be sent from then on.
    pub(crate) fn deadline(&self) -> Instant {
        self.handed_over_at + self.request.lane.timeout()
    }

    pub(crate) fn is_overdue(&self, now: Instant) -> bool {
        now >= self.deadline()
    }
}

/// Serves a lane until there are no more requests.
pub(crate) async fn serve(
    connector: Connector,
    token: Arc<str>,
    mut requests: Receiver<Queued>,
    inbox: Arc<Inbox>,
) {
    let mut connection = Connection::open(&connector).await.ok();
    loop {
        let queued = match timeout(LOOK_INTERVAL, requests.recv()).await {
            Ok(Some(queued)) => queued,
            Ok(None) => return,
            Err(_) => {
                if connection.as_ref().is_none_or(Connection::is_closed) {
                    connection = Connection::open(&connector).await.ok();
                }
                continue;
            }
        };
        let id = queued.request.id;
        if queued.is_overdue(Instant::now()) {
            inbox.put(Received::NoAnswer { id });
            continue;
        }
        let answered = ask(&connector, &token, &mut connection, &queued);
        match timeout_at(queued.deadline(), answered).await {
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
/// `None`: there was no answer, or the request was overdue before it could be sent.
pub(crate) async fn ask(
    connector: &Connector,
    token: &str,
    connection: &mut Option<Connection>,
    queued: &Queued,
) -> Option<(u16, Vec<u8>)> {
    let call = &queued.request.call;
    for _ in 0..2 {
        let is_new = connection.as_ref().is_none_or(Connection::is_closed);
        if is_new {
            *connection = Some(Connection::open(connector).await.ok()?);
        }
        if queued.is_overdue(Instant::now()) {
            return None;
        }
        let asked = Asked {
            method: match call.method() {
                Method::Get => hyper::Method::GET,
                Method::Post => hyper::Method::POST,
            },
            path: call.path(),
            body: call.body(),
        };
        match connection.as_mut()?.ask(connector, token, asked).await {
            Ok(answer) => return Some(answer),
            Err(_) if !is_new => *connection = None,
            Err(_) => return None,
        }
    }
    None
}
