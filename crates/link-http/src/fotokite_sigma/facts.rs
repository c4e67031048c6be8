//! What a vehicle says of itself, for `check` and for the address of its video. Nothing is changed by asking.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_wire::fotokite_sigma::control::refusal;
use barrelman_wire::fotokite_sigma::json::{self, CameraInfo, CameraState, HandoffState, VideoStream};

use super::Sigma;
use crate::named_video::MainVideo;

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

    /// The main video; `None`: the vehicle has none.
    ///
    /// # Errors
    /// What the vehicle says instead.
    pub fn main_video(&self) -> Result<Option<MainVideo>, Acceptance> {
        let streams: Vec<VideoStream> = self.read("/v1/videostreams")?;
        let main = json::main_stream(&streams);
        Ok(main.map(|stream| MainVideo {
            name: stream.stream_id.clone(),
            address: stream.rtsp_url.clone().or_else(|| stream.rtsps_url.clone()),
        }))
    }

    fn read<T: for<'a> serde::Deserialize<'a>>(&self, path: &str) -> Result<T, Acceptance> {
        let (status, body) = super::get(&self.0, path).map_err(|_| Acceptance::Unanswered)?;
        match refusal(status) {
            Some(said) => Err(said),
            None => json::read(&body).ok_or(Acceptance::Fault),
        }
    }
}
