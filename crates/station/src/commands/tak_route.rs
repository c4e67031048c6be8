//! How events for TAK go, as the configuration says.

use anyhow::{Context as _, Result};
use tokio_rustls::rustls::pki_types::ServerName;

use crate::config::TakConfig;
use crate::secrets;
use crate::tak::{Encryption, TakAddress, TakRoute, Transport};

/// Looks the host of an address up, and reads the files of TLS.
///
/// # Errors
/// If the host is not known, or a file is not usable.
pub(super) fn tak_route(address: &TakAddress, config: &TakConfig) -> Result<TakRoute> {
    let to = address.resolve()?;
    Ok(match address.transport {
        Transport::Udp => TakRoute::Udp(to),
        Transport::Tcp => TakRoute::Tcp(to, None),
        Transport::Tls => {
            let name = ServerName::try_from(address.host().to_owned())
                .with_context(|| format!("the host of {address} is no name of a server"))?;
            let config = secrets::tls_client(&config.trust, config.client.as_ref())?;
            TakRoute::Tcp(to, Some(Encryption { config, name }))
        }
    })
}
