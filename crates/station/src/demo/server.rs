//! The web server of the demo's page: a listener and a thread around the routes of [`super::routes`].

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;

use anyhow::{Context, Result};
use tokio::sync::oneshot;

use super::page::PageState;
use super::routes::{self, RouteState};
use crate::live::event::Event;
use crate::live::threads;

/// A running server. Dropping it ends the server and all its connections.
pub struct PageServer {
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl PageServer {
    /// Starts the server on a thread of its own.
    ///
    /// # Errors
    /// If the system has no more threads, or the socket cannot be used.
    pub fn start(listener: TcpListener, page: Arc<PageState>, events: SyncSender<Event>) -> Result<Self> {
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let router = routes::router(RouteState::new(page, address));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("the page's server cannot be started")?;
        let (end, ended) = oneshot::channel::<()>();
        let thread = threads::spawn("page", events, move || {
            runtime.block_on(async {
                let listener = match tokio::net::TcpListener::from_std(listener) {
                    Ok(listener) => listener,
                    Err(error) => return tracing::error!("the page cannot be served: {error}"),
                };
                // A response of `/video` has no end: dropping the server's future closes the connections.
                tokio::select! {
                    served = axum::serve(listener, router).into_future() => {
                        if let Err(error) = served {
                            tracing::error!("the page cannot be served: {error}");
                        }
                    }
                    _ = ended => {}
                }
            });
        })?;
        Ok(Self { address, end: Some(end), thread: Some(thread) })
    }

    /// The address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
