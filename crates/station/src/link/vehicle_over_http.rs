//! A vehicle that is asked over HTTP: whether profile and address fit together, and what the vehicle says of its video.

use anyhow::{Context, Result, bail};
use barrelman_link::LinkUrl;
use barrelman_link::url::Endpoint;
use barrelman_link_http::{HttpSettings, Inquiry};
use barrelman_vocab::profile::Protocol;
use barrelman_wire::fotokite_sigma::json::{self, VideoStream};

use crate::config::Configuration;
use crate::secrets;

/// Whether the vehicles of a protocol are asked over HTTP.
pub const fn is_over_http(protocol: Protocol) -> bool {
    matches!(protocol, Protocol::FotokiteSigma)
}

/// How the vehicle of a configuration is reached over HTTP; `None`: it is reached otherwise, or there is none.
///
/// # Errors
/// If the profile and the address do not fit together, or a secret is not usable.
pub fn vehicle_over_http(
    configuration: &Configuration,
    link: Option<&LinkUrl>,
) -> Result<Option<HttpSettings>> {
    let profile = &configuration.profile;
    match link.map(|link| &link.endpoint) {
        None | Some(Endpoint::SimulatedCamera) => Ok(None),
        Some(Endpoint::Http(address)) if is_over_http(profile.protocol) => {
            secrets::http_settings(address, &configuration.link_access).map(Some)
        }
        Some(Endpoint::Http(address)) => bail!(
            "the link {address} is for a vehicle that is asked over HTTP, and {} is none: give --profile fotokite-sigma",
            profile.name
        ),
        Some(_) if is_over_http(profile.protocol) => bail!(
            "the vehicle {} is asked over HTTP: give --link http://192.168.2.100:3128/api or --link https://HOST/api",
            profile.name
        ),
        Some(_) => Ok(None),
    }
}

/// The address of the vehicle's main video stream.
///
/// # Errors
/// If the vehicle cannot be reached, refuses the token, or names no stream without encryption.
pub fn video_address(settings: &HttpSettings) -> Result<String> {
    let remedy = "give the address of the video with --video rtsp://...";
    let (status, body) = Inquiry::open(settings)?
        .get("/v1/videostreams")
        .with_context(|| format!("{} does not tell its video streams: {remedy}", settings.address))?;
    if status != 200 {
        bail!("{} does not tell its video streams (status {status}): {remedy}", settings.address);
    }
    let streams: Vec<VideoStream> = json::read(&body)
        .with_context(|| format!("{} tells video streams that cannot be read: {remedy}", settings.address))?;
    let Some(stream) = json::main_stream(&streams) else {
        bail!("{} has no video stream: is its camera mounted and on? Or {remedy}", settings.address);
    };
    stream.rtsp_url.clone().with_context(|| {
        format!(
            "{} offers its stream {:?} by RTSPS alone, which this program does not read: use the vehicle's own network, or a \
             relay (`stunnel`), and {remedy}",
            settings.address, stream.stream_id
        )
    })
}
