//! The routes of the links and of the pages that opened them.
//!
//! | request | answer | needs |
//! |---|---|---|
//! | `GET /api/v1/links` | [`LinksBody`] | control |
//! | `GET /api/v1/links/control.svg`, `.../watch.svg` | a link as a QR code | control |
//! | `POST /api/v1/links` | new tokens: all other pages and programs are signed out; [`LinksBody`] | control |
//! | `DELETE /api/v1/pages/NUMBER` | signs a page out, with all pages of its browser | control |

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{delete, get};
use qrcode::QrCode;
use qrcode::render::svg;

use super::access::Pass;
use super::admission::{Route, json, may_control};
use super::issued_links::LinksBody;
use super::seats::ClientId;
use super::shared::Console;
use crate::snapshot::Level;

type Shared = State<Arc<Console>>;

/// The smallest side of a QR code, pixels.
const SIDE: u32 = 240;

/// The routes, without the guard of all routes.
pub(super) fn routes() -> [Route; 3] {
    [
        ("/api/v1/links", get(links).post(renew)),
        ("/api/v1/links/{name}", get(code)),
        ("/api/v1/pages/{id}", delete(sign_out)),
    ]
}

async fn links(State(console): Shared, headers: HeaderMap) -> Response {
    match may_control(&console.access, &headers) {
        Ok(_) => unkept(json(&console.links.body(&console.access))),
        Err(refusal) => *refusal,
    }
}

async fn code(State(console): Shared, Path(name): Path<String>, headers: HeaderMap) -> Response {
    if let Err(refusal) = may_control(&console.access, &headers) {
        return *refusal;
    }
    let LinksBody { control, watch, .. } = console.links.body(&console.access);
    let link = match name.as_str() {
        "control.svg" => control,
        "watch.svg" => watch,
        _ => return (StatusCode::NOT_FOUND, "there are control.svg and watch.svg\n").into_response(),
    };
    match QrCode::new(link.as_bytes()) {
        Ok(code) => {
            let svg = code.render::<svg::Color<'_>>().min_dimensions(SIDE, SIDE).build();
            unkept(([(header::CONTENT_TYPE, "image/svg+xml")], svg).into_response())
        }
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}

async fn renew(State(console): Shared, headers: HeaderMap) -> Response {
    let pass = match may_control(&console.access, &headers) {
        Ok(pass) => pass,
        Err(refusal) => return *refusal,
    };
    if !console.access.asks_for_tokens() {
        return (StatusCode::CONFLICT, "this console asks for no token\n").into_response();
    }
    let kept: Vec<Pass> = Some(pass).filter(Pass::is_cookie).into_iter().collect();
    if let Err(error) = console.links.renew(&console.access, &kept) {
        return (StatusCode::INTERNAL_SERVER_ERROR, format!("{error:#}\n")).into_response();
    }
    console.sign_out();
    // The disk may be slow; a Stop does not wait for it.
    let worker = Arc::clone(&console);
    let written = tokio::task::spawn_blocking(move || worker.links.keep(&worker.access)).await;
    let warning = match written {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(not_kept(&format!("{error:#}"))),
        Err(error) => Some(not_kept(&error.to_string())),
    };
    let text = warning.clone().unwrap_or_else(|| "new links: all other pages are signed out".to_owned());
    console.events.add(console.time.now(), Level::Warning, "links-renewed", text);
    unkept(json(&LinksBody { warning, ..console.links.body(&console.access) }))
}

/// What is said of new links that are not in all their files.
fn not_kept(reason: &str) -> String {
    format!(
        "the links are new, and all other pages are signed out, but {reason}; make the file writable, and choose New links again"
    )
}

async fn sign_out(State(console): Shared, Path(id): Path<ClientId>, headers: HeaderMap) -> Response {
    if let Err(refusal) = may_control(&console.access, &headers) {
        return *refusal;
    }
    let Some(pass) = console.pass_of_page(id) else {
        return (StatusCode::NOT_FOUND, "no such page is connected\n").into_response();
    };
    if !console.access.revoke(&pass) {
        let text = "only new links sign out who has a token and no cookie: POST /api/v1/links\n";
        return (StatusCode::CONFLICT, text).into_response();
    }
    console.sign_out();
    let text = format!("page {id} is signed out");
    console.events.add(console.time.now(), Level::Warning, "page-signed-out", text);
    StatusCode::NO_CONTENT.into_response()
}

/// An answer with a token, which no cache keeps.
fn unkept(mut response: Response) -> Response {
    response.headers_mut().insert(header::CACHE_CONTROL, header::HeaderValue::from_static("no-store"));
    response
}
