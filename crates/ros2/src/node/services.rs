//! The services, both `std_srvs/Trigger`.

use std::future::Future;

use anyhow::Result;
use futures_util::StreamExt as _;
use futures_util::stream::FuturesUnordered;
use ros2_client::service::Server;
use ros2_client::{Name, Node, ServiceMapping, ServiceTypeName};

use super::qos;
use crate::calls::failed;
use crate::messages::{TriggerRequest, TriggerResponse};

/// Calls that wait for their answers, at most.
const MAX_CALLS: usize = 32;

/// A service.
pub struct Calls {
    server: Server<TriggerRequest, TriggerResponse>,
}

impl Calls {
    pub(super) fn offer(node: &mut Node, path: &str, name: &str, mapping: ServiceMapping) -> Result<Self> {
        let service = ServiceTypeName::new("std_srvs", "Trigger");
        let name = Name::new(path, name)?;
        let server = node.create_server(mapping, &name, &service, qos::service(), qos::service())?;
        Ok(Self { server })
    }
}

/// Serves the calls of a service. What `begin` does before its first wait is done for each call at once,
/// however many calls wait.
pub async fn serve<A: Future<Output = TriggerResponse>>(calls: &Calls, mut begin: impl FnMut() -> A) {
    let mut requests = calls.server.receive_request_stream();
    let mut answers = FuturesUnordered::new();
    loop {
        tokio::select! {
            biased;
            Some(request) = requests.next() => {
                // What cannot be read is no call: its sender is not known.
                let Ok((id, _)) = request else { continue };
                let answer = begin();
                if answers.len() < MAX_CALLS {
                    answers.push(async move { (id, answer.await) });
                } else {
                    let response = failed("too many calls wait for their answers");
                    let _ = calls.server.async_send_response(id, response).await;
                }
            }
            Some((id, response)) = answers.next() => {
                // A caller that is gone gets no answer.
                let _ = calls.server.async_send_response(id, response).await;
            }
            else => return,
        }
    }
}
