//! A vehicle that is asked over HTTP: whether profile and address fit together, and what the vehicle says of its video.

use anyhow::{Result, anyhow, bail};
use barrelman_link::LinkUrl;
use barrelman_link::url::Endpoint;
use barrelman_link_http::{HttpSettings, Inquiry, MainVideo};
use barrelman_video::VideoUrl;
use barrelman_vocab::Named as _;

use crate::config::Configuration;
use crate::link::named_video::{PermittedHosts, named_video};
use crate::secrets;

/// How the vehicle of a configuration is reached over HTTP; `None`: it is reached otherwise, or there is none.
///
/// # Errors
/// If the profile and the address do not fit together, or a secret is not usable.
pub fn vehicle_over_http(
    configuration: &Configuration,
    link: Option<&LinkUrl>,
) -> Result<Option<HttpSettings>> {
    let profile = &configuration.profile;
    let is_over_http = profile.protocol.is_over_http();
    match link.map(|link| &link.endpoint) {
        None | Some(Endpoint::SimulatedCamera) => Ok(None),
        Some(Endpoint::Http(address)) if is_over_http => {
            secrets::http_settings(address, &configuration.link_access).map(Some)
        }
        Some(Endpoint::Http(address)) => bail!(
            "the link {address} is for a vehicle that is asked over HTTP, and {} is none: give --profile fotokite-sigma",
            profile.name
        ),
        Some(_) if is_over_http => bail!(
            "the vehicle {} is asked over HTTP: give --link http://sigma.example:3128/api or --link https://HOST/api",
            profile.name
        ),
        Some(_) => Ok(None),
    }
}

/// The vehicle's main video, at the address that the vehicle names. `permitted`: a host for it beside that of the link.
///
/// # Errors
/// If the vehicle cannot be reached, refuses the token, or names no video, or one that is not opened.
pub fn video_of_vehicle(settings: &HttpSettings, permitted: Option<&str>) -> Result<VideoUrl> {
    let HttpSettings { address, .. } = settings;
    let remedy = "give the address of the video with --video rtsp://...";
    let main = Inquiry::open(settings)?.main_video();
    match main.map_err(|said| anyhow!("{address} does not tell its video: {}. Or {remedy}", said.text()))? {
        Some(MainVideo { address: Some(url), .. }) => {
            let hosts = PermittedHosts { link: &address.host, configured: permitted };
            named_video(&url, hosts).map_err(|error| anyhow!("{error}. Or {remedy}"))
        }
        Some(MainVideo { name, .. }) => bail!("{address} tells no address of its video {name:?}: {remedy}"),
        None => bail!("{address} has no video: is its camera mounted and on? Or {remedy}"),
    }
}
