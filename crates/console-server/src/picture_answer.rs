//! The answer with the newest picture.

use axum::body::Body;
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse as _, Response};

use super::newest_picture::{Drawing, StillPicture};
use super::shared::Console;

/// The time of capture of a picture, as `select` has it.
const CAPTURED: HeaderName = HeaderName::from_static("captured-ns");

/// The newest picture, which no cache keeps.
/// `query`: that of the address.
pub(super) async fn picture(console: &Console, query: Option<&str>) -> Response {
    let drawing = match query {
        None | Some("" | "overlay=false") => Drawing::Plain,
        Some("overlay=true") => Drawing::Overlay,
        Some(_) => return (StatusCode::BAD_REQUEST, "send ?overlay=true, or no query\n").into_response(),
    };
    let time = console.time.clone();
    match console.tracked_video().pictures.newest.get(drawing, move |at| time.time_of_day(at)).await {
        Ok(Some(StillPicture { jpeg, captured })) => {
            let headers = [
                (header::CONTENT_TYPE, "image/jpeg".to_owned()),
                (header::CACHE_CONTROL, "no-store".to_owned()),
                (CAPTURED, captured.as_nanos().to_string()),
            ];
            (headers, Body::from(jpeg)).into_response()
        }
        Ok(None) => {
            let video = console.status().video.state;
            let text = format!("there is no picture yet: the video is {video}\n");
            (StatusCode::SERVICE_UNAVAILABLE, [(header::CACHE_CONTROL, "no-store")], text).into_response()
        }
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}
