//! A relay on the loopback in front of an RTSP server.
//!
//! `rtspsrc` sends a password as Basic to a server that offers nothing else, follows redirects with the
//! login, and tells little of a server's answers. The relay sees all messages ([`super::messages`]) and
//! reaches one server: wherever an answer leads, a login goes nowhere else.

use std::io::{self, Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use url::Url;

use super::super::failure::from_status;
use super::super::play::Play;
use super::super::reach;
use super::messages::{Answers, RTSP_PORT, Refusal, Requests};

/// Bytes that are read at once.
const READ_BYTES: usize = 64 << 10;

/// Maximum number of connections, one after the other: the first one, and one for each redirect.
const MAX_CONNECTIONS: usize = 4;

/// Requests whose answer decides about the stream. The others keep the session alive.
const DECISIVE: [&str; 3] = ["DESCRIBE", "SETUP", "PLAY"];

/// A server, and what is known of it.
pub(super) struct Server {
    /// The address of the stream.
    pub(super) url: Url,
    /// Whether a password may be sent as it is, without TLS.
    pub(super) permits_basic: bool,
    /// The encoding that the server sends and does not announce.
    pub(super) sent: Option<&'static str>,
}

/// Starts a relay to a server. Returns the address that leads through the relay.
pub(super) fn start(play: &Arc<Play>, server: Server) -> io::Result<Url> {
    let Server { url, permits_basic, sent } = server;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let near = listener.local_addr()?;
    let mut through = url.clone();
    let is_set = through.set_host(Some("127.0.0.1")).is_ok() && through.set_port(Some(near.port())).is_ok();
    if !is_set {
        return Err(io::Error::from(io::ErrorKind::InvalidInput));
    }
    let play = Arc::downgrade(play);
    std::thread::spawn(move || {
        for client in listener.incoming().take(MAX_CONNECTIONS) {
            let Ok(client) = client else { return };
            match reach::connect(&url, RTSP_PORT) {
                Ok(server) => {
                    let relay = Relay { play: play.clone(), client, server, method: Mutex::default() };
                    Arc::new(relay).pass(permits_basic, Answers::new(near, url.clone(), sent));
                }
                Err(error) => {
                    if let Some(play) = play.upgrade() {
                        play.set_reason(reach::unreachable(&error));
                    }
                    return;
                }
            }
        }
    });
    Ok(through)
}

struct Relay {
    play: Weak<Play>,
    client: TcpStream,
    server: TcpStream,
    /// Method of the last request.
    method: Mutex<String>,
}

impl Relay {
    /// Passes messages in both directions until an end closes.
    fn pass(self: Arc<Self>, permits_basic: bool, mut answers: Answers) {
        let _ = self.client.set_nodelay(true);
        let _ = self.server.set_nodelay(true);
        let answering = self.clone();
        std::thread::spawn(move || {
            answering.pass_one_way(&answering.server, &answering.client, |relay, bytes, out| {
                let status = answers.pass(bytes, out)?;
                status.into_iter().for_each(|status| relay.on_status(status));
                Ok(())
            });
        });
        let mut requests = Requests::new(permits_basic);
        self.pass_one_way(&self.client, &self.server, |relay, bytes, out| {
            if let Some(method) = requests.pass(bytes, out)? {
                *relay.method.lock().unwrap_or_else(PoisonError::into_inner) = method;
            }
            Ok(())
        });
    }

    fn pass_one_way(
        &self,
        mut from: &TcpStream,
        mut to: &TcpStream,
        mut filter: impl FnMut(&Self, &[u8], &mut Vec<u8>) -> Result<(), Refusal>,
    ) {
        let (mut bytes, mut out) = (vec![0; READ_BYTES], Vec::new());
        loop {
            let read = match from.read(&mut bytes) {
                Ok(0) => break,
                Ok(read) => read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(_) => break,
            };
            out.clear();
            if let Err(refusal) = filter(self, &bytes[..read], &mut out) {
                if let (Some(play), Some(failure)) = (self.play.upgrade(), refusal.failure()) {
                    play.set_reason(failure);
                }
                break;
            }
            if to.write_all(&out).is_err() {
                break;
            }
        }
        let _ = self.client.shutdown(Shutdown::Both);
        let _ = self.server.shutdown(Shutdown::Both);
    }

    /// A status explains the failure that follows it. A good one explains nothing.
    fn on_status(&self, status: u16) {
        let method = self.method.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(play) = self.play.upgrade()
            && DECISIVE.contains(&method.as_str())
        {
            match from_status(status) {
                Some(failure) => play.set_reason(failure),
                None => play.forget_reason(),
            }
        }
    }
}
