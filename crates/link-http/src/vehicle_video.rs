//! Asks a vehicle of any protocol for its video.

use barrelman_link::port::PortError;

use crate::fotokite_sigma::Sigma;
use crate::inquiry::not_usable;
use crate::named_video::VehicleVideo;
use crate::onvif::Camera;
use crate::settings::{HttpProtocol, HttpSettings};

/// The video of the vehicle; `None`: it has none.
///
/// # Errors
/// If the vehicle cannot be reached, does not tell its video, or has none of the chosen name.
pub fn vehicle_video(settings: &HttpSettings) -> Result<Option<VehicleVideo>, PortError> {
    match &settings.protocol {
        HttpProtocol::FotokiteSigma(sigma) => {
            let told = Sigma::reach(settings, &sigma.credential)?.video(sigma.stream.as_deref());
            told.map_err(|error| not_usable(settings, error.to_string()))
        }
        HttpProtocol::Onvif(onvif) => {
            let told = Camera::reach(settings, onvif)?.video();
            told.map(Some).map_err(|error| not_usable(settings, error.to_string()))
        }
    }
}
