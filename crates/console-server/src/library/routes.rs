//! The routes of the library.
//!
//! | request | answer | needs |
//! |---|---|---|
//! | `GET /library` | the page | |
//! | `GET /api/v1/recordings` | the recordings, the newest first | token |
//! | `GET /api/v1/recordings/NAME/sortie.json` | the summary, also of one that was cut off | token |
//! | `GET /api/v1/recordings/NAME/part/MS` | video and scenes from a moment on ([`super::part`]); `?form=jpeg` | token |
//! | `GET /api/v1/recordings/NAME/thumbnail.jpg` | a picture from its middle | token |
//! | `GET /api/v1/recordings/NAME/FILE` | `recording.mcap`, `annotated.mp4`, `report.html`, `video.mp4`, `trial.csv`; ranges | token |
//! | `POST /api/v1/recordings/NAME/film` | begins to make film and tables | control, disengaged |
//! | `POST /api/v1/recordings/NAME/name` | renames: `{"to": "NAME.mcap"}` | control, disengaged |
//! | `DELETE /api/v1/recordings/NAME` | deletes | control, disengaged |

use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{delete, get, post};
use schemars::JsonSchema;
use serde::Deserialize;
use tower::ServiceExt as _;
use tower_http::services::ServeFile;

use super::Library;
use super::name::RecordingName;
use super::part::{ENGAGED, Form, Part};
use crate::admission::{Route, json, may_control, may_enter};
use crate::files;
use crate::routes::json_body;
use crate::shared::Console;

type Shared = State<Arc<Console>>;
type Refusal = Box<Response>;

/// The routes, without the guard of all routes.
pub(crate) fn routes() -> [Route; 9] {
    [
        ("/library", get(|| async { files::response("library.html") })),
        ("/api/v1/recordings", get(list)),
        ("/api/v1/recordings/{name}", delete(remove)),
        ("/api/v1/recordings/{name}/film", post(make_film)),
        ("/api/v1/recordings/{name}/name", post(rename)),
        ("/api/v1/recordings/{name}/sortie.json", get(sortie)),
        ("/api/v1/recordings/{name}/part/{from_ms}", get(part)),
        ("/api/v1/recordings/{name}/thumbnail.jpg", get(thumbnail)),
        ("/api/v1/recordings/{name}/{file}", get(file)),
    ]
}

/// A new name of a recording.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewName {
    /// The name, with `.mcap` at its end.
    to: String,
}

async fn list(State(console): Shared, headers: HeaderMap) -> Response {
    answer(async {
        may_enter(&console.access, &headers)?;
        let listed = reading(&console, Library::list).await?;
        Ok(json(&listed))
    })
    .await
}

async fn sortie(State(console): Shared, Path(name): Path<String>, headers: HeaderMap) -> Response {
    answer(async {
        may_enter(&console.access, &headers)?;
        let name = parse(&name)?;
        let stored = name.clone();
        if let Some(sortie) = reading(&console, move |library| library.stored_sortie(&stored)).await? {
            return Ok(json(&sortie));
        }
        let library = library_of(&console)?;
        let worker = Arc::clone(&library);
        let observed = library.observing.work(move || worker.observed_sortie(&name)).await;
        match observed.map_err(as_refusal)? {
            Ok(sortie) => Ok(json(&sortie)),
            Err(reason) => Err(refusal(StatusCode::UNPROCESSABLE_ENTITY, reason)),
        }
    })
    .await
}

async fn file(
    State(console): Shared,
    Path((name, file)): Path<(String, String)>,
    request: Request,
) -> Response {
    answer(async {
        may_enter(&console.access, request.headers())?;
        let name = parse(&name)?;
        let asked = file.clone();
        let found =
            within(&console, move |library| Ok(library.file(&name, &asked).map(|path| (path, name)))).await?;
        let Some((path, name)) = found else {
            return Err(refusal(StatusCode::NOT_FOUND, format!("there is no {file} of this recording")));
        };
        let mut response = match ServeFile::new(path).oneshot(request).await {
            Ok(response) => response.into_response(),
            Err(never) => match never {},
        };
        let ending = file.rsplit_once('.').map_or("", |(_, ending)| ending);
        // The stem holds no quotation mark. A name beyond ASCII is left to the browser.
        let as_named = format!("inline; filename=\"{}.{ending}\"", name.stem());
        if let Ok(value) = as_named.parse() {
            response.headers_mut().insert(header::CONTENT_DISPOSITION, value);
        }
        Ok(response)
    })
    .await
}

async fn part(
    State(console): Shared,
    Path((name, from_ms)): Path<(String, u64)>,
    uri: Uri,
    headers: HeaderMap,
) -> Response {
    answer(async {
        may_enter(&console.access, &headers)?;
        let name = parse(&name)?;
        let form = match uri.query() {
            None | Some("") => Form::AsReceived,
            Some("form=jpeg") => Form::Jpeg,
            Some(_) => {
                return Err(refusal(StatusCode::BAD_REQUEST, "send ?form=jpeg, or no query".to_owned()));
            }
        };
        let session = Arc::clone(&console);
        let found = reading(&console, move |library| {
            library
                .part(&name, Duration::from_millis(from_ms), form, &|| !session.may_follow())
                .map_err(as_io_error)
        });
        let Some(Part { items, next, began }) = found.await? else {
            let text = "the recording has no index, as it was cut off or is being written: make its film";
            return Err(refusal(StatusCode::NOT_FOUND, text.to_owned()));
        };
        let mut response = items.into_response();
        let headers = response.headers_mut();
        headers.insert("x-began-ns", began.as_nanos().into());
        if let Some(next) = next {
            // Rounded up: the part that shows this moment begins with the key unit.
            let ms = next.as_nanos().div_ceil(1_000_000);
            headers.insert("x-next-ms", u64::try_from(ms).unwrap_or(u64::MAX).into());
        }
        Ok(response)
    })
    .await
}

async fn thumbnail(State(console): Shared, Path(name): Path<String>, headers: HeaderMap) -> Response {
    answer(async {
        may_enter(&console.access, &headers)?;
        let name = parse(&name)?;
        // Asked when its turn has come: the camera may be engaged by then.
        let asked = Arc::clone(&console);
        let found = reading(&console, move |library| match asked.may_follow() {
            true => Err(io::Error::new(io::ErrorKind::ResourceBusy, ENGAGED)),
            false => library.thumbnail(&name).map_err(as_io_error),
        });
        match found.await? {
            Some(picture) => {
                let headers =
                    [(header::CONTENT_TYPE, "image/jpeg"), (header::CACHE_CONTROL, "private, max-age=3600")];
                Ok((headers, picture).into_response())
            }
            None => Err(refusal(StatusCode::NOT_FOUND, "there is no picture of this recording".to_owned())),
        }
    })
    .await
}

async fn make_film(State(console): Shared, Path(name): Path<String>, headers: HeaderMap) -> Response {
    answer(async {
        may_change(&console, &headers)?;
        let name = parse(&name)?;
        within(&console, move |library| library.make_film(&name)).await?;
        Ok(StatusCode::ACCEPTED.into_response())
    })
    .await
}

async fn rename(State(console): Shared, Path(name): Path<String>, request: Request) -> Response {
    answer(async {
        may_change(&console, request.headers())?;
        let from = parse(&name)?;
        let body = json_body(request).await?;
        let NewName { to } = serde_json::from_slice(&body).map_err(|error| {
            refusal(StatusCode::BAD_REQUEST, format!("send {{\"to\": \"NAME.mcap\"}}: {error}"))
        })?;
        let to = parse(&to)?;
        within(&console, move |library| library.rename(&from, &to)).await?;
        Ok(StatusCode::NO_CONTENT.into_response())
    })
    .await
}

async fn remove(State(console): Shared, Path(name): Path<String>, headers: HeaderMap) -> Response {
    answer(async {
        may_change(&console, &headers)?;
        let name = parse(&name)?;
        within(&console, move |library| library.delete(&name)).await?;
        Ok(StatusCode::NO_CONTENT.into_response())
    })
    .await
}

async fn answer(work: impl Future<Output = Result<Response, Refusal>>) -> Response {
    work.await.unwrap_or_else(|refusal| *refusal)
}

/// Anyone who has the token for control, while the camera does not follow.
fn may_change(console: &Console, headers: &HeaderMap) -> Result<(), Refusal> {
    may_control(&console.access, headers)?;
    if console.may_follow() {
        return Err(refusal(StatusCode::CONFLICT, "disengage the camera first".to_owned()));
    }
    Ok(())
}

fn parse(name: &str) -> Result<RecordingName, Refusal> {
    name.parse()
        .map_err(|why| refusal(StatusCode::BAD_REQUEST, format!("{name:?} is no name of a recording: {why}")))
}

fn library_of(console: &Console) -> Result<Arc<Library>, Refusal> {
    let text = || "this program has no folder of recordings".to_owned();
    console.library.clone().ok_or_else(|| refusal(StatusCode::NOT_FOUND, text()))
}

/// Reads recordings, once it is this request's turn.
async fn reading<T: Send + 'static>(
    console: &Console,
    work: impl FnOnce(&Library) -> io::Result<T> + Send + 'static,
) -> Result<T, Refusal> {
    let library = library_of(console)?;
    let worker = Arc::clone(&library);
    library.reading.work(move || work(&worker)).await.map_err(as_refusal)
}

/// Works on the library's files, away from the thread of the console. Reads no recording.
async fn within<T: Send + 'static>(
    console: &Console,
    work: impl FnOnce(&Library) -> io::Result<T> + Send + 'static,
) -> Result<T, Refusal> {
    let library = library_of(console)?;
    let done = tokio::task::spawn_blocking(move || work(&library)).await;
    done.unwrap_or_else(|error| Err(io::Error::other(error))).map_err(as_refusal)
}

/// An error of the library's files as it is, any other one with all its reasons.
fn as_io_error(error: anyhow::Error) -> io::Error {
    error.downcast().unwrap_or_else(|error| io::Error::other(format!("{error:#}")))
}

fn as_refusal(error: io::Error) -> Refusal {
    let status = match error.kind() {
        io::ErrorKind::NotFound => StatusCode::NOT_FOUND,
        io::ErrorKind::AlreadyExists | io::ErrorKind::ResourceBusy => StatusCode::CONFLICT,
        _ => StatusCode::INTERNAL_SERVER_ERROR,
    };
    refusal(status, error.to_string())
}

fn refusal(status: StatusCode, text: String) -> Refusal {
    Box::new((status, format!("{text}\n")).into_response())
}
