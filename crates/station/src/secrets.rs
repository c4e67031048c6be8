//! Logins and tokens that stay off the command line: in a file, or in an environment variable that the
//! configuration names.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, anyhow, bail};

use barrelman_host::clock::Clock;
use barrelman_host::input;
use barrelman_link::url::HttpAddress;
use barrelman_link_http::settings::Fingerprint;
use barrelman_link_http::{
    ClientIdentity, Credential, HttpProtocol, HttpSettings, SigmaAccess, Trust, client_config,
};
use barrelman_video::VideoUrl;
use barrelman_video::url::Login;
use barrelman_vocab::{Timestamp, VehicleProfile};
use barrelman_wire::onvif::{self, OnvifSettings};
use barrelman_wire::{Signing, SigningKey};
use tokio_rustls::rustls::ClientConfig;

use crate::source_url::SourceUrl;

/// Where a login is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LoginSource {
    /// `user:password` on the first line of this file, and on the second one, if there is one,
    /// `host HOST:PORT` of the camera.
    File(PathBuf),
    /// `user:password` in the environment variable of this name.
    Environment(String),
}

/// The login of a video, and how it may be used.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VideoLogin {
    /// Where the login is kept, if it is not in the address.
    pub source: Option<LoginSource>,
    /// Whether the password may be sent as it is (Basic) without TLS.
    pub permits_basic: bool,
}

/// A login with the server that it is for.
struct StoredLogin {
    login: Login,
    /// `HOST` or `HOST:PORT` of the second line, behind the word `host`; `None`: that of the address beside
    /// which the login is given.
    server: Option<String>,
}

/// What proves who asks a vehicle over HTTP, and which vehicle is the right one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LinkAccess {
    /// The file of the token.
    pub token_file: Option<PathBuf>,
    /// The file of the login.
    pub login_file: Option<PathBuf>,
    /// Which certificate is accepted.
    pub trust: TrustFiles,
}

/// Which certificate of a server is accepted; neither: one that a well-known authority has signed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TrustFiles {
    /// The fingerprint of the certificate.
    pub certificate_sha256: Option<String>,
    /// The file of the authorities that sign the certificate.
    pub ca_file: Option<PathBuf>,
}

/// The own certificate for a server, and its key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientFiles {
    /// The certificate.
    pub certificate: PathBuf,
    /// Its key.
    pub key: PathBuf,
}

impl LoginSource {
    /// Reads the login. If others may read the file, a warning is logged.
    ///
    /// # Errors
    /// If the file or the variable does not exist, or holds no login. The message repeats nothing of the
    /// content.
    fn read(&self) -> Result<StoredLogin> {
        match self {
            Self::File(path) => read_file(path),
            Self::Environment(name) => {
                let text = std::env::var(name).map_err(|_| {
                    anyhow!(
                        "video.login_env names the environment variable {name}, which is not set or is not UTF-8: \
                         set it to user:password"
                    )
                })?;
                let login = Login::parse(&text)
                    .with_context(|| format!("the environment variable {name} is not usable"))?;
                Ok(StoredLogin { login, server: None })
            }
        }
    }
}

/// Parses the address of a video source and adds the login. The login is read only for a camera at `rtsp://`;
/// other sources take none.
///
/// # Errors
/// If the address cannot be parsed, or the login cannot be read.
pub fn source_url(address: &str, login: &VideoLogin) -> Result<SourceUrl> {
    Ok(match SourceUrl::parse(address)? {
        SourceUrl::Video(url) => SourceUrl::Video(with_login(url, login, Recipient::TheCamera)?),
        SourceUrl::Simulated(url) => SourceUrl::Simulated(url),
    })
}

/// Adds the login to an address that the vehicle named: only a login that is stored for that host and port,
/// as a vehicle chooses nobody whom a password is shown to; or, without one, the link's own for the link's
/// own host.
///
/// # Errors
/// If the login cannot be read, or is for another server.
pub fn named_source_url(url: VideoUrl, login: &VideoLogin, link: Option<&HttpSettings>) -> Result<SourceUrl> {
    let HttpSettings { address, protocol, .. } = match link {
        Some(link) if login.source.is_none() => link,
        _ => return with_login(url, login, Recipient::NamedByVehicle).map(SourceUrl::Video),
    };
    if let HttpProtocol::Onvif(OnvifSettings { login: Some(own), .. }) = protocol
        && url.server().is_some_and(|(host, _)| host.eq_ignore_ascii_case(&address.host))
    {
        let (user, password) = (own.user().to_owned(), own.password().to_owned());
        let own = Login { user, password, permits_basic: false };
        return Ok(SourceUrl::Video(url.with_login(own)?));
    }
    with_login(url, login, Recipient::NamedByVehicle).map(SourceUrl::Video)
}

/// Parses the address of the second video of a run and adds the login, unless the login is stored for another
/// server.
///
/// # Errors
/// If the address cannot be parsed, or the login cannot be read.
pub fn second_source_url(address: &str, login: &VideoLogin) -> Result<SourceUrl> {
    Ok(match SourceUrl::parse(address)? {
        SourceUrl::Video(url) => SourceUrl::Video(with_login(url, login, Recipient::OneOfTwo)?),
        SourceUrl::Simulated(url) => SourceUrl::Simulated(url),
    })
}

/// Whom a login would be sent to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Recipient {
    /// The camera that the operator names.
    TheCamera,
    /// The second camera that the operator names.
    OneOfTwo,
    /// A camera that the vehicle names.
    NamedByVehicle,
}

fn with_login(url: VideoUrl, login: &VideoLogin, recipient: Recipient) -> Result<VideoUrl> {
    let url = match (&login.source, url.server()) {
        (Some(source), Some((host, port))) => {
            let stored = source.read()?;
            let shown =
                if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") };
            match stored.server {
                Some(server)
                    if recipient == Recipient::OneOfTwo && !is_server(&server, &host, port, &url) =>
                {
                    url
                }
                Some(server) if !is_server(&server, &host, port, &url) => bail!(
                    "the login is for {server}, as its file says, and the video is at {shown}: it is not sent there. If both are \
                     the same camera, correct the second line of the file"
                ),
                None if recipient == Recipient::NamedByVehicle => bail!(
                    "the vehicle names its video at {shown}, and a login is sent to no address that a vehicle chooses: if that is \
                     the right camera, write `host {shown}` on the second line of the login file, or give --video"
                ),
                Some(_) | None => url.with_login(stored.login)?,
            }
        }
        _ => url,
    };
    Ok(if login.permits_basic { url.permitting_basic() } else { url })
}

/// Whether `HOST` or `HOST:PORT` is this server. Without a port it is the usual one of the address.
fn is_server(text: &str, host: &str, port: u16, url: &VideoUrl) -> bool {
    let scheme = if url.tls_server().is_some() { "rtsps" } else { "rtsp" };
    let stated = VideoUrl::parse_stream(&format!("{scheme}://{text}")).ok().and_then(|url| url.server());
    stated.is_some_and(|(stated, at)| stated.eq_ignore_ascii_case(host) && at == port)
}

/// What a link over HTTP needs, with the token or the login of its file, and the vehicle's video that is
/// used. If others may read the file, a warning is logged.
///
/// # Errors
/// If a Sigma's token file is not named, or a file or the fingerprint is not usable. The message repeats
/// nothing of a secret.
pub fn http_settings(
    address: &HttpAddress,
    access: &LinkAccess,
    profile: &VehicleProfile,
    video_stream: Option<&str>,
) -> Result<HttpSettings> {
    let stream = video_stream.map(str::to_owned);
    let protocol = if address.scheme.is_onvif() {
        let login = access.login_file.as_deref().map(camera_login).transpose()?;
        HttpProtocol::Onvif(OnvifSettings { login, speeds: profile.speeds.clone(), profile: stream })
    } else {
        let credential = sigma_credential(address, access)?;
        HttpProtocol::FotokiteSigma(SigmaAccess { credential, stream, full_zoom: profile.max_zoom_rate() })
    };
    Ok(HttpSettings { address: address.clone(), trust: trust(&access.trust)?, protocol })
}

/// The login of an ONVIF camera in its file. If others may read the file, a warning is logged.
///
/// # Errors
/// If the file is not usable. The message repeats nothing of its content.
pub fn camera_login(path: &Path) -> Result<onvif::Login> {
    let StoredLogin { login, .. } = read_file(path)?;
    Ok(onvif::Login::new(login.user, login.password))
}

fn sigma_credential(address: &HttpAddress, access: &LinkAccess) -> Result<Credential> {
    let path = access.token_file.as_deref().with_context(|| {
        format!("the vehicle at {address} asks for a token: give --link-token-file FILE, or link.token_file")
    })?;
    let content = read_secret(path, "token")?;
    Credential::parse(&content).with_context(|| format!("the token file {} is not usable", path.display()))
}

/// Which certificate of a server is accepted, with the authorities of their file.
///
/// # Errors
/// If the file or the fingerprint is not usable.
pub fn trust(files: &TrustFiles) -> Result<Trust> {
    Ok(match (&files.certificate_sha256, &files.ca_file) {
        (Some(text), _) => Trust::Fingerprint(
            Fingerprint::parse(text).with_context(|| format!("the fingerprint {text:?} is not usable"))?,
        ),
        (None, Some(path)) => Trust::Authorities(input::read(path)?),
        (None, None) => Trust::WellKnown,
    })
}

/// TLS to a server that is not a vehicle's. If others may read the key, a warning is logged.
///
/// # Errors
/// If a file is not usable. The message repeats nothing of the key.
pub fn tls_client(files: &TrustFiles, client: Option<&ClientFiles>) -> Result<Arc<ClientConfig>> {
    let read = |files: &ClientFiles| -> Result<ClientIdentity> {
        let certificate = input::read(&files.certificate)?;
        Ok(ClientIdentity { certificate, key: read_secret(&files.key, "key")?.into_bytes() })
    };
    let identity = client.map(read).transpose()?;
    let config = client_config(&trust(files)?, identity.as_ref());
    config.context("the files of TLS are not usable").map(Arc::new)
}

/// How the packets of a MAVLink link are signed, with the key of this file; without a file, they are not. If
/// others may read the file, a warning is logged.
///
/// # Errors
/// If the file is not usable. The message repeats nothing of its content.
pub fn mavlink_signing(key_file: Option<&Path>, clock: Clock) -> Result<Option<Signing>> {
    let Some(path) = key_file else { return Ok(None) };
    let content = read_secret(path, "signing key")?;
    let key = SigningKey::parse(&content)
        .with_context(|| format!("the signing key file {} is not usable", path.display()))?;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let began = since_1970.saturating_sub(clock.now().since(Timestamp::ZERO));
    Ok(Some(Signing::new(key, began.as_millis() as u64)))
}

fn read_file(path: &Path) -> Result<StoredLogin> {
    let text = read_secret(path, "login")?;
    let mut lines = text.lines();
    let login = Login::parse(lines.next().unwrap_or_default())
        .with_context(|| format!("the login file {} is not usable", path.display()))?;
    let server =
        lines.next().and_then(|line| line.strip_prefix("host ")).map(|server| server.trim().to_owned());
    Ok(StoredLogin { login, server })
}

/// Reads a file of a secret, and warns if others may read it. `kind`: what it holds.
fn read_secret(path: &Path, kind: &str) -> Result<String> {
    if input::is_readable_by_others(path) {
        tracing::warn!(
            "the {kind} file {} can be read by others: run `chmod 600 {}`",
            path.display(),
            path.display()
        );
    }
    String::from_utf8(input::read(path)?)
        .map_err(|_| anyhow!("it is not UTF-8 text"))
        .with_context(|| format!("the {kind} file {} is not usable", path.display()))
}
