//! The task of a lane: one request after the other, each within the lane's time, on a connection of its own.

use std::sync::Arc;
use std::time::Duration;

use barrelman_wire::http::{HttpCall, Received, Request};
use tokio::sync::mpsc::Receiver;
use tokio::time::{Instant, timeout, timeout_at};

use crate::connection::{Asked, Connection, Connector};
use crate::inbox::Inbox;

/// Interval at which a connection at rest is looked at: a command must not wait for a new one.
const LOOK_INTERVAL: Duration = Duration::from_millis(500);

/// A request that waits in its lane. Its time begins when it is handed to the lane: connecting takes from it,
/// too.
#[derive(Debug)]
pub(crate) struct Queued {
    pub(crate) id: u64,
    pub(crate) asked: Asked,
    /// The end of the request's time. It must not be sent from then on.
    pub(crate) deadline: Instant,
}

impl Queued {
    /// A request that is handed over now.
    pub(crate) fn now<C: HttpCall>(request: &Request<C>) -> Self {
        let deadline = Instant::now() + C::timeout(request.lane);
        Self { id: request.id, asked: Asked::from(&request.call), deadline }
    }

    pub(crate) fn is_overdue(&self, now: Instant) -> bool {
        now >= self.deadline
    }
}

/// Serves a lane until there are no more requests.
pub(crate) async fn serve(connector: Connector, mut requests: Receiver<Queued>, inbox: Arc<Inbox>) {
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
        let id = queued.id;
        if queued.is_overdue(Instant::now()) {
            inbox.put(Received::NoAnswer { id });
            continue;
        }
        let answered = ask(&connector, &mut connection, &queued);
        match timeout_at(queued.deadline, answered).await {
            Ok(Some((status, body))) => inbox.put(Received::Answer { id, status, body }),
            Ok(None) | Err(_) => {
                // What was sent on it may come late, and must not meet the next request.
                connection = None;
                inbox.put(Received::NoAnswer { id });
            }
        }
    }
}

/// Asks on the open connection, or on a new one. A connection that the vehicle had closed meanwhile is
/// replaced once. `None`: there was no answer, or the request was overdue before it could be sent.
pub(crate) async fn ask(
    connector: &Connector,
    connection: &mut Option<Connection>,
    queued: &Queued,
) -> Option<(u16, Vec<u8>)> {
    for _ in 0..2 {
        let is_new = connection.as_ref().is_none_or(Connection::is_closed);
        if is_new {
            *connection = Some(Connection::open(connector).await.ok()?);
        }
        if queued.is_overdue(Instant::now()) {
            return None;
        }
        match connection.as_mut()?.ask(connector, &queued.asked).await {
            Ok(answer) => return Some(answer),
            Err(_) if !is_new => *connection = None,
            Err(_) => return None,
        }
    }
    None
}
