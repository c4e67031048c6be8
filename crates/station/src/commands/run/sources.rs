//! The video sources of a run, as its arguments, its configuration and its vehicle name them.

use anyhow::{Result, bail};
use barrelman_link_http::HttpSettings;

use crate::cli::{RunArgs, UsageError};
use crate::config::Configuration;
use crate::link::url::Endpoint;
use crate::link::{LinkUrl, video_of_vehicle};
use crate::live::source::Source;
use crate::secrets::{self, TrustFiles};
use crate::source_url::SourceUrl;

/// The address of the video of a run, with its login. A vehicle over HTTP names its video where nobody else
/// does.
///
/// # Errors
/// If nothing names a video, or its login cannot be used.
pub(super) fn first_source(
    args: &RunArgs,
    configuration: &mut Configuration,
    http: Option<&HttpSettings>,
) -> Result<SourceUrl> {
    let mut named = None;
    if let (None, Some(http)) = (&configuration.video, http) {
        let video = video_of_vehicle(http, configuration.link_video_host.as_deref())?;
        tracing::info!("the vehicle's video: {video}");
        configuration.video = Some(video.to_string());
        named = Some(video);
        // One vehicle, one certificate.
        if configuration.video_trust == TrustFiles::default() {
            configuration.video_trust = configuration.link_access.trust.clone();
        }
    }
    let Some(video) = &configuration.video else {
        let file = args.connection.config.as_ref();
        let file = file.map_or_else(|| "the configuration".to_owned(), |path| path.display().to_string());
        let remedy = "give --video rtsp://..., --video file:clip.mp4, --video sim:arena1, or video.url in";
        return Err(UsageError(format!("no video source: {remedy} {file}")).into());
    };
    let source = match named {
        Some(video) => secrets::named_source_url(video, &configuration.video_login, http)?,
        None => secrets::source_url(video, &configuration.video_login)?,
    };
    // A server that takes no login was refused with its login.
    let has_server = matches!(&source, SourceUrl::Video(url) if url.server().is_some());
    if args.connection.video_login_file.is_some() && !has_server {
        return Err(UsageError(format!(
            "--video-login-file is for rtsp://, rtsps://, http:// and https://: {source} takes no login"
        ))
        .into());
    }
    Ok(source)
}

/// Checks that a link to a simulated camera has the camera's world.
pub(in crate::commands) fn ensure_camera_has_world(link: Option<&LinkUrl>, source: &Source) -> Result<()> {
    if source.world().is_none() && link.is_some_and(|link| link.endpoint == Endpoint::SimulatedCamera) {
        bail!("--link sim: moves the camera of a simulated world: give --video sim:SCENARIO with it");
    }
    Ok(())
}

/// The second video of a run, if there is one.
pub(super) fn second_source(configuration: &Configuration) -> Result<Option<Source>> {
    let Some(second) = &configuration.second_video else { return Ok(None) };
    let url = secrets::second_source_url(&second.url, &configuration.video_login)?;
    if let SourceUrl::Simulated(url) = &url {
        bail!("{url} cannot be the second video: one world is simulated; give it as the first --video");
    }
    Source::load(url, secrets::trust(&configuration.video_trust)?).map(Some)
}
