//! The routes of the map.
//!
//! | request | answer | needs |
//! |---|---|---|
//! | `GET /api/v1/map/ZOOM/X/Y` | a tile: PNG, JPEG or WebP; 204: none is there; 404: there is no map | token |

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use axum::routing::get;

use super::tile::TileAt;
use crate::admission::{Route, may_enter};
use crate::shared::Console;

type Shared = State<Arc<Console>>;

/// A tile may be kept for a day: the browser does not ask for it again with each picture.
const KEPT: &str = "private, max-age=86400";

/// The routes, without the guard of all routes.
pub(crate) fn routes() -> [Route; 1] {
    [("/api/v1/map/{zoom}/{x}/{y}", get(tile))]
}

async fn tile(
    State(console): Shared,
    Path((zoom, x, y)): Path<(u8, u32, u32)>,
    headers: HeaderMap,
) -> Response {
    if let Err(response) = may_enter(&console.access, &headers) {
        return *response;
    }
    let Some(map) = console.map.clone() else {
        return (StatusCode::NOT_FOUND, "this program has no map: give --map\n").into_response();
    };
    let Some(at) = TileAt::new(zoom, x, y) else { return StatusCode::NO_CONTENT.into_response() };
    match tokio::task::spawn_blocking(move || map.tile(at)).await {
        Ok(Ok(Some((kind, bytes)))) => {
            ([(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, KEPT)], bytes).into_response()
        }
        Ok(Ok(None)) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(error)) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}
