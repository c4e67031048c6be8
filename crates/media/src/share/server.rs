//! The RTSP server: one path, packets in the TCP connection, and a pipeline for each reader.

use std::sync::Arc;

use barrelman_media_protocol::share::{SHARE_USER, ShareSettings};
use gstreamer as gst;
use gstreamer_app::AppSrc;
use gstreamer_rtsp_server::gst_rtsp::{RTSPAuthMethod, RTSPLowerTrans, RTSPStatusCode};
use gstreamer_rtsp_server::prelude::*;
use gstreamer_rtsp_server::{
    RTSPAuth, RTSPClient, RTSPContext, RTSPMedia, RTSPMediaFactory, RTSPServer, RTSPThreadPool, RTSPToken,
};

use super::audience::Audience;

/// Each access unit is sent as it comes, every key frame with its parameter sets.
const PIPELINE: &str = "( appsrc name=units is-live=true do-timestamp=true format=time \
    caps=video/x-h264,stream-format=byte-stream,alignment=au \
    ! rtph264pay name=pay0 pt=96 config-interval=-1 aggregate-mode=zero-latency )";

/// The plugins of [`PIPELINE`] and of the server's own elements: they are loaded while files can be read.
const PLUGINS: [&str; 5] = ["app", "coreelements", "rtp", "rtpmanager", "udp"];

/// Largest body of a request, bytes. No request of a reader needs one.
const MAX_BODY: u32 = 4096;

/// Loads what the server needs.
///
/// # Errors
/// A plugin is missing.
pub(super) fn load_plugins() -> Result<(), String> {
    PLUGINS.iter().try_for_each(|name| match gst::Plugin::load_by_name(name) {
        Ok(_) => Ok(()),
        Err(_) => Err(format!("GStreamer lacks its plugin {name}")),
    })
}

/// The server, without connections.
///
/// # Errors
/// The path cannot be served.
pub(super) fn new(settings: &ShareSettings, audience: &Arc<Audience>) -> Result<RTSPServer, String> {
    let server = RTSPServer::new();
    let factory = RTSPMediaFactory::new();
    factory.set_launch(PIPELINE);
    // The pipeline of a reader that is slow holds up no other one.
    factory.set_shared(false);
    factory.set_protocols(RTSPLowerTrans::TCP);
    let (configured, connected) = (audience.clone(), audience.clone());
    factory.connect_media_configure(move |_, media| configure(&configured, media));
    if let Some(password) = &settings.password {
        let access = gst::Structure::builder(SHARE_USER)
            .field("media.factory.access", true)
            .field("media.factory.construct", true);
        factory.add_role_from_structure(&access.build());
        server.set_auth(Some(&digest_alone(password)));
    }
    let mounts = server.mount_points().ok_or("the server has no paths")?;
    mounts.add_factory(&settings.path, factory);
    // A thread for each client: one that is waited for holds up no other one.
    let threads = RTSPThreadPool::new();
    threads.set_max_threads(-1);
    server.set_thread_pool(Some(&threads));
    server.connect_client_connected(move |_, client| connect(&connected, client));
    Ok(server)
}

fn digest_alone(password: &str) -> RTSPAuth {
    let auth = RTSPAuth::new();
    auth.set_supported_methods(RTSPAuthMethod::Digest);
    auth.set_realm(Some("barrelman"));
    let token = RTSPToken::builder().field("media.factory.role", SHARE_USER).build();
    auth.add_digest(SHARE_USER, password, &token);
    auth
}

/// A client has come: the audience hears what it asks for.
fn connect(audience: &Arc<Audience>, client: &RTSPClient) {
    client.set_content_length_limit(MAX_BODY);
    audience.arrive(client);
    let on_closed = audience.clone();
    client.connect_closed(move |client| on_closed.leave(client));
    let (on_describe, on_setup) = (audience.clone(), audience.clone());
    client.connect_pre_describe_request(move |client, _| admission(&on_describe, client));
    client.connect_pre_setup_request(move |client, _| admission(&on_setup, client));
    let (on_play, on_pause) = (audience.clone(), audience.clone());
    client.connect_play_request(move |client, _| on_play.play(client));
    client.connect_pause_request(move |client, _| on_pause.pause(client));
}

fn admission(audience: &Audience, client: &RTSPClient) -> RTSPStatusCode {
    if audience.may_read(client) { RTSPStatusCode::Ok } else { RTSPStatusCode::NotEnoughBandwidth }
}

/// Connects the pipeline of a reader. This runs in the thread of its client, in the course of its request.
fn configure(audience: &Arc<Audience>, media: &RTSPMedia) {
    let client = RTSPContext::with_current_context(|context| context.client().cloned()).flatten();
    let bin = media.element().downcast::<gst::Bin>().ok();
    let source = bin.and_then(|bin| bin.by_name("units")).and_then(|units| units.downcast::<AppSrc>().ok());
    let (Some(client), Some(source)) = (client, source) else { return };
    let (on_end, ended) = (audience.clone(), source.clone());
    media.connect_unprepared(move |_| on_end.forget(&ended));
    audience.describe(&client, source);
}
