//! What a vehicle says of itself, for `check` and for the address of its video. Nothing is changed by asking.

use barrelman_vocab::Named as _;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_wire::fotokite_sigma::control::refusal;
use barrelman_wire::fotokite_sigma::json::{self, CameraInfo, CameraState, HandoffState, VideoStream};

use super::Sigma;
use crate::named_video::VehicleVideo;

/// Why a vehicle's video is not known.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum VideoError {
    /// The vehicle does not tell it.
    #[error("{}", .0.text())]
    Refused(Acceptance),
    /// None is called so.
    #[error("the vehicle has no video {chosen:?}: let video.stream be one of {choices}")]
    NoStream {
        /// What the operator wrote.
        chosen: String,
        /// The names, with commas.
        choices: String,
    },
}

impl Sigma {
    /// The speeds that the camera takes, degrees per second.
    ///
    /// # Errors
    /// What the vehicle says instead.
    pub fn camera_info(&self) -> Result<CameraInfo, Acceptance> {
        self.read("/v1/camera/info")
    }

    /// Whether the camera is on line.
    ///
    /// # Errors
    /// What the vehicle says instead.
    pub fn is_camera_online(&self) -> Result<bool, Acceptance> {
        let state: CameraState = self.read("/v1/camera/state")?;
        Ok(state.online_state.as_deref() != Some("Offline"))
    }

    /// The name of the client that controls the vehicle; `None`: there is none.
    ///
    /// # Errors
    /// What the vehicle says instead.
    pub fn controller(&self) -> Result<Option<String>, Acceptance> {
        let state: HandoffState = self.read("/v1/handoff/state")?;
        let name = |client: json::ControllingClient| {
            client.operator_name.unwrap_or_else(|| "another client".to_owned())
        };
        Ok(state.controlling_client.map(name))
    }

    /// The chosen video, or the main one; `None`: the vehicle has none.
    ///
    /// # Errors
    /// What the vehicle says instead, or that it has none of the chosen name.
    pub fn video(&self, chosen: Option<&str>) -> Result<Option<VehicleVideo>, VideoError> {
        let streams: Vec<VideoStream> = self.read("/v1/videostreams").map_err(VideoError::Refused)?;
        let choices: Vec<String> = streams.iter().map(|stream| stream.stream_id.clone()).collect();
        match (json::main_stream(&streams, chosen), chosen) {
            (Some(stream), _) => Ok(Some(VehicleVideo {
                name: stream.stream_id.clone(),
                address: stream.rtsp_url.clone().or_else(|| stream.rtsps_url.clone()),
                choices,
            })),
            (None, Some(chosen)) if !choices.is_empty() => {
                Err(VideoError::NoStream { chosen: chosen.to_owned(), choices: choices.join(", ") })
            }
            (None, _) => Ok(None),
        }
    }

    fn read<T: for<'a> serde::Deserialize<'a>>(&self, path: &str) -> Result<T, Acceptance> {
        let (status, body) = super::get(&self.0, path).map_err(|_| Acceptance::Unanswered)?;
        match refusal(status) {
            Some(said) => Err(said),
            None => json::read(&body).ok_or(Acceptance::Fault),
        }
    }
}
