//! The messages that a camera understands.

use core::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;

use crate::onvif::duration::duration_of;
use crate::onvif::login::PASSWORD_DIGEST;
use crate::onvif::velocity::SpeedShares;

/// A message.
pub(super) struct Message {
    pub(super) security: Option<Security>,
    pub(super) asked: Asked,
}

/// Who asks, and its proof.
pub(super) struct Security {
    pub(super) user: String,
    pub(super) digest: String,
    pub(super) nonce: Vec<u8>,
    pub(super) created: String,
}

/// What is asked.
pub(super) enum Asked {
    DateAndTime,
    Services,
    Capabilities,
    Profiles,
    StreamUri { profile: String },
    MoveOptions { configuration: String },
    Status { profile: String },
    Move { profile: String, velocity: SpeedShares, timeout: Option<Duration> },
    Stop { profile: String },
    Other,
}

/// Reads a message; `None`: it is none.
pub(super) fn read(message: &[u8]) -> Option<Message> {
    let text = core::str::from_utf8(message).ok()?;
    let Envelope { header, body } = quick_xml::de::from_str(text).ok()?;
    let token = header.and_then(|header| header.security).map(|security| security.token);
    Some(Message { security: token.and_then(security), asked: asked(body.request)? })
}

fn security(token: UsernameToken) -> Option<Security> {
    let is_digest = token.password.kind.as_deref() == Some(PASSWORD_DIGEST);
    let nonce = STANDARD.decode(token.nonce?.text.trim()).ok()?;
    let (user, digest, created) = (token.user, token.password.text, token.created?);
    is_digest.then_some(Security { user, digest, nonce, created })
}

fn asked(request: Request) -> Option<Asked> {
    Some(match request {
        Request::GetSystemDateAndTime {} => Asked::DateAndTime,
        Request::GetServices {} => Asked::Services,
        Request::GetCapabilities {} => Asked::Capabilities,
        Request::GetProfiles {} => Asked::Profiles,
        Request::GetStreamUri { profile } => Asked::StreamUri { profile },
        Request::GetConfigurationOptions { configuration } => Asked::MoveOptions { configuration },
        Request::GetStatus { profile } => Asked::Status { profile },
        Request::Stop { profile } => Asked::Stop { profile },
        Request::ContinuousMove { profile, velocity, timeout } => {
            let turn = velocity.pan_tilt.map_or((0.0, 0.0), |vector| (vector.x, vector.y));
            let velocity =
                SpeedShares { pan: turn.0, tilt: turn.1, zoom: velocity.zoom.map_or(0.0, |scalar| scalar.x) };
            let timeout = match timeout {
                Some(text) => Some(duration_of(&text)?),
                None => None,
            };
            Asked::Move { profile, velocity, timeout }
        }
        Request::Other => Asked::Other,
    })
}

#[derive(Deserialize)]
struct Envelope {
    #[serde(rename = "Header")]
    header: Option<Header>,
    #[serde(rename = "Body")]
    body: Body,
}

#[derive(Deserialize)]
struct Header {
    #[serde(rename = "Security")]
    security: Option<SecurityHeader>,
}

#[derive(Deserialize)]
struct SecurityHeader {
    #[serde(rename = "UsernameToken")]
    token: UsernameToken,
}

#[derive(Deserialize)]
struct UsernameToken {
    #[serde(rename = "Username")]
    user: String,
    #[serde(rename = "Password")]
    password: Password,
    #[serde(rename = "Nonce")]
    nonce: Option<Text>,
    #[serde(rename = "Created")]
    created: Option<String>,
}

#[derive(Deserialize)]
struct Password {
    #[serde(rename = "@Type")]
    kind: Option<String>,
    #[serde(rename = "$text", default)]
    text: String,
}

#[derive(Deserialize)]
struct Text {
    #[serde(rename = "$text", default)]
    text: String,
}

#[derive(Deserialize)]
struct Body {
    #[serde(rename = "$value")]
    request: Request,
}

#[derive(Deserialize)]
enum Request {
    GetSystemDateAndTime {},
    GetServices {},
    GetCapabilities {},
    GetProfiles {},
    GetStreamUri {
        #[serde(rename = "ProfileToken")]
        profile: String,
    },
    GetConfigurationOptions {
        #[serde(rename = "ConfigurationToken")]
        configuration: String,
    },
    GetStatus {
        #[serde(rename = "ProfileToken")]
        profile: String,
    },
    ContinuousMove {
        #[serde(rename = "ProfileToken")]
        profile: String,
        #[serde(rename = "Velocity")]
        velocity: Velocity,
        #[serde(rename = "Timeout")]
        timeout: Option<String>,
    },
    Stop {
        #[serde(rename = "ProfileToken")]
        profile: String,
    },
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
struct Velocity {
    #[serde(rename = "PanTilt")]
    pan_tilt: Option<Vector>,
    #[serde(rename = "Zoom")]
    zoom: Option<Scalar>,
}

#[derive(Deserialize)]
struct Scalar {
    #[serde(rename = "@x")]
    x: f64,
}

#[derive(Deserialize)]
struct Vector {
    #[serde(rename = "@x")]
    x: f64,
    #[serde(rename = "@y")]
    y: f64,
}
