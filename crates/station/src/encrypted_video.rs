//! Video sources, those in TLS through a relay on the loopback: the RTSP library has no TLS.

use anyhow::{Context, Result};
use barrelman_host::clock::Clock;
use barrelman_link_http::{RelayFailures, TlsRelay, TlsServer, Trust};
use barrelman_video::sender_clock::VideoTiming;
use barrelman_video::{DecodeError, VideoHandle, VideoSink, VideoState, VideoUrl};
use barrelman_vocab::{EncodedUnit, PixelBox, VideoFrame};

/// Starts a video source.
///
/// # Errors
/// If the relay or the thread of the source cannot be started. An error of the source itself reaches the
/// sink.
pub(crate) fn spawn(
    url: VideoUrl,
    trust: &Trust,
    clock: Clock,
    sink: impl VideoSink + 'static,
) -> Result<VideoHandle> {
    let Some((host, port)) = url.tls_server() else {
        return Ok(barrelman_video::spawn(url, clock, sink)?);
    };
    let relay = TlsRelay::start(TlsServer { host, port }, trust)
        .with_context(|| format!("{url} cannot be reached over TLS"))?;
    let failures = relay.failures();
    let url = url.through(relay.address());
    Ok(barrelman_video::spawn(url, clock, Explained { sink, failures })?.keeping(relay))
}

/// Tells why the relay does not reach the server, where the source only sees a connection that is closed.
struct Explained<S> {
    sink: S,
    failures: RelayFailures,
}

impl<S: VideoSink> VideoSink for Explained<S> {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        self.sink.on_unit(unit);
    }

    fn on_frame(&mut self, frame: VideoFrame) {
        self.sink.on_frame(frame);
    }

    fn on_target(&mut self, target: PixelBox) {
        self.sink.on_target(target);
    }

    fn on_timing(&mut self, timing: VideoTiming) {
        self.sink.on_timing(timing);
    }

    fn on_damage(&mut self, error: &DecodeError) {
        self.sink.on_damage(error);
    }

    fn on_state(&mut self, state: VideoState) {
        self.sink.on_state(match (state, self.failures.newest()) {
            (VideoState::Lost { .. }, Some(reason)) => VideoState::Lost { reason },
            (state, _) => state,
        });
    }
}
