//! A door to a server on loopback that asks nobody for a token: who comes over the network shows one first.
//!
//! ```text
//! client --TLS--> GET /?token=... -> the server on loopback gets the request without the token, then all bytes
//! ```
//! Encryption and limits of connections are those of the console. A connection ends with its token.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use barrelman_host::clock::Clock;
use barrelman_host::threads;
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _, copy_bidirectional};
use tokio::net::TcpStream;
use tokio::time::timeout;

use super::access::Role;
use super::https::{Accepted, Identity, accept};
use super::limited_stream::{Bytes, LimitedStream};
use super::limits::{BYTES, HEADER_TIMEOUT};
use super::places::{Place, Places};
use super::server::{prepare, runtime};
use super::settings::{ConsoleAddress, identity, listener_at};
use super::tokens::TokensInForce;

/// Bytes of a request's head, at most.
const HEAD_BYTES: usize = 8 << 10;
/// How often a connection's token is looked at.
const TOKEN_INTERVAL: Duration = Duration::from_secs(1);
/// Pause after a connection that failed before it was accepted: too many open files stay too many for a
/// while.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// A door that is open, and leads nowhere yet.
pub struct TokenDoor {
    listener: std::net::TcpListener,
    address: SocketAddr,
    passing: Passing,
}

/// What a connection has to pass.
#[derive(Clone)]
struct Passing {
    tokens: TokensInForce,
    https: Option<Arc<Identity>>,
    clock: Clock,
}

impl TokenDoor {
    /// Opens a door for those who know one of these tokens.
    ///
    /// # Errors
    /// If there are no tokens, the address is in use, or the certificate cannot be read or made.
    pub fn open(at: ConsoleAddress, tokens: TokensInForce, clock: Clock) -> Result<Self> {
        if !tokens.are_asked_for() {
            bail!(
                "other devices come in with the console's watch token, and there is none: leave out --headless, name a file of \
                 tokens (console.token_file), or listen on 127.0.0.1"
            );
        }
        let listener = listener_at(at.listen)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let https = identity(at.encryption, address.ip(), &at.host_names)?.map(Arc::new);
        Ok(Self { listener, address, passing: Passing { tokens, https, clock } })
    }

    /// The address of the door, for a client of WebSockets.
    pub fn url(&self) -> String {
        let scheme = if self.passing.https.is_some() { "wss" } else { "ws" };
        format!("{scheme}://{}", self.address)
    }

    /// Lets connections through to a server of this machine, on a thread of this name, until the program
    /// ends.
    ///
    /// # Errors
    /// If the system has no more threads or descriptors.
    pub fn lead_to(self, server: SocketAddr, thread: &str) -> Result<()> {
        let Self { listener, passing, .. } = self;
        let runtime = runtime().context("the door cannot be opened")?;
        let on_panic = |thread| tracing::error!("the thread {thread} panicked: nobody is let in any more");
        threads::spawn(thread, on_panic, move || {
            runtime.block_on(async {
                match tokio::net::TcpListener::from_std(listener) {
                    Ok(listener) => let_in(listener, passing, server).await,
                    Err(error) => tracing::error!("nobody can be let in: {error}"),
                }
            });
        })?;
        Ok(())
    }
}

async fn let_in(listener: tokio::net::TcpListener, passing: Passing, server: SocketAddr) {
    let places = Arc::new(Places::new(passing.clock));
    loop {
        match listener.accept().await {
            Ok((stream, client)) => {
                let (place, passing) = (places.take(client.ip()), passing.clone());
                tokio::spawn(async move {
                    tokio::select! {
                        () = pass(stream, &place, passing, server) => {}
                        () = place.gives_way() => {}
                    }
                });
            }
            Err(_) => tokio::time::sleep(ACCEPT_PAUSE).await,
        }
    }
}

/// An error of one connection concerns nobody else.
async fn pass(stream: TcpStream, place: &Place, passing: Passing, server: SocketAddr) {
    prepare(&stream);
    let Passing { tokens, https, clock } = passing;
    let Some(identity) = https else {
        return pass_on(LimitedStream::new(stream, Bytes, BYTES, clock), place, &tokens, server).await;
    };
    match accept(stream, &identity, clock).await {
        Ok(Accepted::Encrypted(stream)) => pass_on(stream, place, &tokens, server).await,
        Ok(Accepted::Plain(stream)) => {
            refuse(stream, "400 Bad Request", "this address is encrypted: use wss:// in place of ws://\n")
                .await;
        }
        Err(_) => {}
    }
}

async fn pass_on<S: AsyncRead + AsyncWrite + Unpin>(
    mut client: S,
    place: &Place,
    tokens: &TokensInForce,
    server: SocketAddr,
) {
    let Ok(Some(received)) = timeout(HEADER_TIMEOUT, head(&mut client)).await else { return };
    let known = received.token().filter(|token| tokens.opens(token)).map(str::to_owned);
    let Some(token) = known else {
        let text = "add the console's watch token to the address: ?token=TOKEN\n";
        return refuse(client, "401 Unauthorized", text).await;
    };
    place.show(Role::Watch);
    let Ok(mut stream) = TcpStream::connect(server).await else { return };
    if stream.write_all(&received.without_query()).await.is_err() {
        return;
    }
    tokio::select! {
        _ = copy_bidirectional(&mut client, &mut stream) => {}
        () = ends(tokens, &token) => {}
    }
}

/// Returns when a token is no longer in force.
async fn ends(tokens: &TokensInForce, token: &str) {
    while tokens.opens(token) {
        tokio::time::sleep(TOKEN_INTERVAL).await;
    }
}

async fn refuse<S: AsyncRead + AsyncWrite + Unpin>(mut client: S, status: &str, text: &str) {
    let answer = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{text}",
        text.len()
    );
    let _ = client.write_all(answer.as_bytes()).await;
    let _ = client.shutdown().await;
}

/// What a connection begins with: the head of a request, and bytes behind it.
struct Received {
    bytes: Vec<u8>,
    /// Where the target of the request begins and ends: `/path?query`.
    target: (usize, usize),
}

/// Reads the head of a request. `None`: it is none, or too long.
async fn head<S: AsyncRead + Unpin>(client: &mut S) -> Option<Received> {
    let mut bytes = Vec::new();
    while !bytes.windows(4).any(|end| end == b"\r\n\r\n") {
        let room = HEAD_BYTES.checked_sub(bytes.len()).filter(|room| *room > 0)?;
        let read = (&mut *client).take(room as u64).read_buf(&mut bytes).await.ok()?;
        if read == 0 {
            return None;
        }
    }
    Received::of(bytes)
}

impl Received {
    fn of(bytes: Vec<u8>) -> Option<Self> {
        let line = bytes.split(|byte| *byte == b'\r').next()?;
        let target = line.strip_prefix(b"GET ")?.strip_suffix(b" HTTP/1.1")?;
        std::str::from_utf8(target).ok()?;
        let target = (4, 4 + target.len());
        Some(Self { bytes, target })
    }

    fn target(&self) -> &str {
        std::str::from_utf8(&self.bytes[self.target.0..self.target.1]).unwrap_or_default()
    }

    fn token(&self) -> Option<&str> {
        let (_, query) = self.target().split_once('?')?;
        query.split('&').find_map(|pair| pair.strip_prefix("token="))
    }

    /// The same for the server, which need not know the token.
    fn without_query(&self) -> Vec<u8> {
        let path = self.target().split('?').next().unwrap_or_default();
        [&self.bytes[..self.target.0], path.as_bytes(), &self.bytes[self.target.1..]].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn received(text: &str) -> Option<Received> {
        Received::of(text.as_bytes().to_vec())
    }

    #[test]
    fn the_token_of_an_address_is_read_and_not_passed_on() {
        for (target, token) in [
            ("/?token=watch-0123456789", Some("watch-0123456789")),
            ("/a?b=c&token=x", Some("x")),
            ("/?token=", Some("")),
            ("/?tokens=x", None),
            ("/token=x", None),
            ("/", None),
        ] {
            let text = format!("GET {target} HTTP/1.1\r\nHost: a\r\n\r\nbehind");
            let head = received(&text).expect(target);
            assert_eq!(head.token(), token, "{target}");
            let path = target.split('?').next().unwrap();
            let passed_on = String::from_utf8(head.without_query()).unwrap();
            assert_eq!(passed_on, format!("GET {path} HTTP/1.1\r\nHost: a\r\n\r\nbehind"));
        }
    }

    #[test]
    fn other_requests_are_none() {
        for text in ["", "\r\n\r\n", "POST / HTTP/1.1\r\n\r\n", "GET /\r\n\r\n", "GET / HTTP/1.0\r\n\r\n"] {
            assert!(received(text).is_none(), "{text:?}");
        }
    }

    #[test]
    fn a_door_needs_a_token() {
        let nobody = TokenDoor::open(ConsoleAddress::default(), TokensInForce::default(), Clock::start());
        let error = nobody.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("leave out --headless"), "{error}");
    }
}
