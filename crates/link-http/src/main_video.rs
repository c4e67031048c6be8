//! Asks a vehicle of any protocol for its video.

use barrelman_link::port::PortError;
use barrelman_vocab::Named as _;

use crate::fotokite_sigma::Sigma;
use crate::inquiry::not_usable;
use crate::named_video::MainVideo;
use crate::onvif::Camera;
use crate::settings::{HttpProtocol, HttpSettings};

/// The main video of the vehicle; `None`: it has none.
///
/// # Errors
/// If the vehicle cannot be reached, or does not tell its video.
pub fn main_video(settings: &HttpSettings) -> Result<Option<MainVideo>, PortError> {
    match &settings.protocol {
        HttpProtocol::FotokiteSigma(credential) => {
            let said = Sigma::reach(settings, credential)?.main_video();
            said.map_err(|said| not_usable(settings, said.text().to_owned()))
        }
        HttpProtocol::Onvif(onvif) => {
            let said = Camera::reach(settings, onvif)?.main_video();
            said.map(Some).map_err(|error| not_usable(settings, error.to_string()))
        }
    }
}
