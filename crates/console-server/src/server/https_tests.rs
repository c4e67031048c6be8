//! HTTPS on a socket of loopback, as a client with the same library sees it.

use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::time::{Instant, SystemTime};

use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::ServerName;
use tokio_rustls::rustls::version::{TLS12, TLS13};
use tokio_rustls::rustls::{
    ClientConfig, ClientConnection, RootCertStore, StreamOwned, SupportedProtocolVersion,
};

use super::super::https::CertificateFiles;
use super::super::in_memory::{CONTROL_TOKEN, InMemory, LIVE, WATCH_TOKEN};
use super::super::limits::HANDSHAKE_TIMEOUT;
use super::*;

const VERSIONS: [&SupportedProtocolVersion; 2] = [&TLS12, &TLS13];

/// An identity of a new authority, and the folder where the authority is kept until this is dropped.
struct Kept {
    identity: Arc<Identity>,
    folder: PathBuf,
}

impl Kept {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("barrelman-https-{name}-{}", std::process::id()));
        let loopback = [127, 0, 0, 1].into();
        let hosts = ["boat.example".to_owned()];
        let identity = Identity::own(&folder.join("authority"), loopback, &hosts, SystemTime::now());
        Self { identity: Arc::new(identity.unwrap()), folder }
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A client that trusts the authority of this identity, or none.
#[derive(Clone)]
struct Client {
    address: SocketAddr,
    roots: RootCertStore,
}

impl Client {
    /// What is heard of a request over TLS.
    fn hear(&self, name: &str, versions: &[&'static SupportedProtocolVersion]) -> io::Result<String> {
        let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
            .with_protocol_versions(versions)
            .map_err(io::Error::other)?
            .with_root_certificates(self.roots.clone())
            .with_no_client_auth();
        let name = ServerName::try_from(name.to_owned()).map_err(io::Error::other)?;
        let connection = ClientConnection::new(Arc::new(config), name).map_err(io::Error::other)?;
        let request = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:8480\r\nConnection: close\r\n\r\n";
        hear(StreamOwned::new(connection, self.connect()), request)
    }

    fn connect(&self) -> std::net::TcpStream {
        std::net::TcpStream::connect(self.address).unwrap()
    }
}

/// What is heard on a connection of a request until its end.
fn hear(mut stream: impl Read + Write, request: &str) -> io::Result<String> {
    stream.write_all(request.as_bytes())?;
    let mut heard = String::new();
    stream.read_to_string(&mut heard)?;
    Ok(heard)
}

/// Runs a client against a console with this identity.
fn with_client<T: Send + 'static>(
    identity: Arc<Identity>,
    trusts: bool,
    act: impl FnOnce(Client) -> T + Send + 'static,
) -> T {
    let session = InMemory::new(LIVE);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let mut roots = RootCertStore::empty();
    if let Some(authority) = identity.authority().filter(|_| trusts) {
        roots.add(authority.der.clone()).unwrap();
    }
    let client = Client { address: listener.local_addr().unwrap(), roots };
    let router = routes::router(Arc::clone(&session.console));
    let answering = Answering { router, https: Some(identity), clock: Clock::start() };
    runtime().unwrap().block_on(async {
        tokio::select! {
            served = serve(listener, answering) => panic!("{served:?}"),
            heard = tokio::task::spawn_blocking(move || act(client)) => heard.unwrap(),
        }
    })
}

#[test]
fn a_device_that_trusts_the_authority_is_answered_by_each_name_of_the_machine() {
    let kept = Kept::new("trusted");
    with_client(Arc::clone(&kept.identity), true, |client| {
        for version in VERSIONS {
            for name in ["127.0.0.1", "localhost", "boat.example"] {
                let heard = client.hear(name, &[version]).unwrap();
                assert!(
                    heard.starts_with("HTTP/1.1 200 OK\r\n") && heard.ends_with("ok\n"),
                    "{name}: {heard}"
                );
            }
        }
    });
}

#[test]
fn a_certificate_is_refused_by_another_name_and_where_the_authority_is_not_trusted() {
    let kept = Kept::new("refused");
    for (trusts, name) in [(true, "evil.example"), (true, "192.168.1.7"), (false, "127.0.0.1")] {
        let heard =
            with_client(Arc::clone(&kept.identity), trusts, move |client| client.hear(name, &VERSIONS));
        let error = heard.unwrap_err().to_string();
        assert!(error.contains("invalid peer certificate"), "{name}: {error}");
    }
}

#[test]
fn a_request_without_tls_hears_of_https_and_nothing_else() {
    let kept = Kept::new("plain");
    for line in ["GET / HTTP/1.1", "POST /api/v1/login HTTP/1.1", "GET /trust HTTP/1.1"] {
        let request = format!(
            "{line}\r\nHost: 127.0.0.1:8480\r\nContent-Length: 0\r\nAuthorization: Bearer {CONTROL_TOKEN}\r\n\r\n"
        );
        let heard =
            with_client(Arc::clone(&kept.identity), true, move |client| hear(client.connect(), &request));
        let heard = heard.unwrap().to_lowercase();
        assert!(heard.starts_with("http/1.1 400 ") && heard.contains("use https://"), "{line}: {heard}");
        for word in [CONTROL_TOKEN, WATCH_TOKEN, "location:", "set-cookie:"] {
            assert!(!heard.contains(word), "{line}: {word:?} is in {heard}");
        }
    }
}

#[test]
fn handshakes_that_do_not_go_on_are_ended_and_delay_nobody() {
    let kept = Kept::new("stalled");
    with_client(Arc::clone(&kept.identity), true, |client| {
        let began = Instant::now();
        let stalled = [&[][..], &[22, 3, 1, 2, 0, 1]].map(|sent| {
            let mut stream = client.connect();
            stream.write_all(sent).unwrap();
            stream
        });
        assert!(client.hear("localhost", &VERSIONS).unwrap().starts_with("HTTP/1.1 200 "));
        assert!(began.elapsed() < HANDSHAKE_TIMEOUT, "{:?}", began.elapsed());
        for mut stream in stalled {
            // Closed, or reset.
            assert!(matches!(stream.read(&mut [0]), Ok(0) | Err(_)));
        }
        assert!(began.elapsed() >= HANDSHAKE_TIMEOUT, "{:?}", began.elapsed());
    });
}

#[test]
fn what_is_no_certificate_or_no_key_of_it_is_said_at_the_start() {
    let folder = std::env::temp_dir().join(format!("barrelman-given-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let [one, other] =
        [(); 2].map(|()| rcgen::generate_simple_self_signed(["boat.example".to_owned()]).unwrap());
    let (certificate, key) =
        (file("one.pem", &one.cert.pem()), file("one.key", &one.signing_key.serialize_pem()));
    let other = file("other.key", &other.signing_key.serialize_pem());
    let nothing = file("nothing.pem", "nothing\n");
    let given = |certificate: &PathBuf, key: &PathBuf| {
        Identity::given(&CertificateFiles { certificate: certificate.clone(), key: key.clone() })
    };
    assert!(given(&certificate, &key).unwrap().authority().is_none());
    for (certificate, key, words) in [
        (&certificate, &other, "cannot be used with the key"),
        (&nothing, &key, "holds no certificate"),
        (&certificate, &nothing, "holds no private key"),
        (&certificate, &folder.join("missing"), "missing"),
    ] {
        let error = format!("{:#}", given(certificate, key).err().unwrap());
        assert!(error.contains(words), "{error}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
