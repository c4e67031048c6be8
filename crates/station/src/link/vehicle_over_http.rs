//! A vehicle that is asked over HTTP: whether profile and address fit together, and what the vehicle says of
//! its video.

use anyhow::{Result, anyhow, bail};
use barrelman_link::LinkUrl;
use barrelman_link::url::{Endpoint, HttpAddress};
use barrelman_link_http::{HttpSettings, vehicle_video};
use barrelman_video::VideoUrl;
use barrelman_vocab::VehicleProfile;
use barrelman_vocab::profile::Addressing;

use crate::config::Configuration;
use crate::link::named_video::{PermittedHosts, named_video};
use crate::secrets;

/// How the vehicle of a configuration is reached over HTTP; `None`: it is reached otherwise, or there is
/// none.
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
        Some(Endpoint::Http(address)) => {
            ensure_spoken_at(address, profile)?;
            let stream = configuration.video_stream.as_deref();
            secrets::http_settings(address, &configuration.link_access, profile, stream).map(Some)
        }
        Some(_) => match profile.protocol.addressing() {
            Addressing::Line => Ok(None),
            own => bail!("the vehicle {} is asked over HTTP: give {}", profile.name, example_link(own)),
        },
    }
}

/// Checks that the profile's protocol is that of the address.
///
/// # Errors
/// If it is not; the message names the remedy.
pub fn ensure_spoken_at(address: &HttpAddress, profile: &VehicleProfile) -> Result<()> {
    let wanted = if address.scheme.is_onvif() { Addressing::Onvif } else { Addressing::HttpApi };
    let own = profile.protocol.addressing();
    if own == wanted {
        return Ok(());
    }
    let mut profiles = VehicleProfile::NAMES.iter().filter_map(|name| VehicleProfile::named(name));
    let suitable =
        profiles.find(|profile| profile.protocol.addressing() == wanted).map(|profile| profile.name);
    bail!(
        "the link {address} is not for the vehicle {}: give --profile {}, or {}",
        profile.name,
        suitable.unwrap_or_default(),
        example_link(own)
    )
}

/// A link that is addressed so.
const fn example_link(addressing: Addressing) -> &'static str {
    match addressing {
        Addressing::Line => "--link serial:/dev/ttyACM0 or --link tcp://HOST:PORT",
        Addressing::HttpApi => "--link http://sigma.example:3128/api or --link https://HOST/api",
        Addressing::Onvif => "--link onvif://HOST",
    }
}

/// The vehicle's video, at the address that the vehicle names. `permitted`: a host for it beside the link's.
///
/// # Errors
/// If the vehicle cannot be reached, refuses the token, or names no video, or one that is not opened.
pub fn video_of_vehicle(settings: &HttpSettings, permitted: Option<&str>) -> Result<VideoUrl> {
    let HttpSettings { address, .. } = settings;
    let remedy = "give the address of the video with --video rtsp://...";
    let told = vehicle_video(settings);
    let told = told.map_err(|error| anyhow!("the vehicle does not tell its video: {error}. Or {remedy}"))?;
    let Some(video) = told else {
        bail!("{address} has no video: is its camera mounted and on? Or {remedy}");
    };
    match &video.address {
        Some(url) => {
            if video.choices.len() > 1 {
                tracing::info!("the vehicle's video is {}", video.among_choices());
            }
            let hosts = PermittedHosts { link: &address.host, configured: permitted };
            named_video(url, hosts).map_err(|error| anyhow!("{error}. Or {remedy}"))
        }
        None => bail!("{address} tells no address of its video {:?}: {remedy}", video.name),
    }
}
