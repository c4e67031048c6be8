//! The files of the page, embedded in the program.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};

macro_rules! files {
    ($($name:literal),+ $(,)?) => {
        /// Name and content of each file.
        pub(super) const FILES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../console/", $name)))),+];
    };
}

files![
    "access.js",
    "clock.js",
    "control_seat.js",
    "decoder.js",
    "events.js",
    "geometry.js",
    "held.js",
    "held_controls.js",
    "index.html",
    "layout.css",
    "link.js",
    "main.js",
    "next_action.js",
    "overlay.js",
    "snapshot_history.js",
    "sounds.js",
    "stage.js",
    "status.js",
    "stop.js",
    "strips.js",
    "style.css",
    "video.js",
    "video_message.js",
    "wake_lock.js",
    "words.en.js",
    "words.js",
];

/// The answer with a file of the page.
pub(super) fn response(name: &str) -> Response {
    match FILES.iter().find(|(own, _)| *own == name) {
        Some((name, content)) => ([(header::CONTENT_TYPE, content_type(name))], *content).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}
