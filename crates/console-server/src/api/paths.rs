//! The paths of the OpenAPI document: every route of the server, with the schemas of what it takes and
//! answers.

use barrelman_trial::sortie::Sortie;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::{Answer, ControlSeat, RequestBody, StatusSnapshot};
use crate::issued_links::LinksBody;
use crate::library::{Listed, NewName};
use crate::routes::AccessBody;

/// The paths. `sent`: what the program writes; `taken`: what it reads.
pub(super) fn paths(sent: &mut SchemaGenerator, taken: &mut SchemaGenerator) -> Map<String, Value> {
    let pages = [
        ("/", "The page of the operator"),
        ("/library", "The page of the recordings"),
        ("/help", "The operator's manual"),
        ("/help/{name}", "A picture of the manual"),
        ("/console/{name}", "A file of the pages"),
        ("/trust", "How a device trusts the console's certificate authority"),
        ("/authority.pem", "The certificate authority, PEM"),
        ("/authority.crt", "The certificate authority, DER"),
    ];
    let mut paths: Map<String, Value> =
        pages.map(|(path, summary)| (path.to_owned(), page(path, summary))).into_iter().collect();
    let others = [session(sent, taken), access(sent), links(sent), vec![map()], recordings(sent, taken)];
    paths.extend(others.into_iter().flatten());
    paths
}

/// The running session.
fn session(sent: &mut SchemaGenerator, taken: &mut SchemaGenerator) -> Vec<(String, Value)> {
    let socket = "WebSocket. Text messages to the program: `#/components/schemas/MessageToProgram`; text messages from \
         the program: `#/components/schemas/MessageToPage`; binary messages from the program: video.";
    let requests = "Makes a request, and waits for its answer. Every kind of request is taken here, those about the control \
         too: `ask-control`, `take-control`, `give-control`, `release-control`.";
    let picture = json!({
        "description": "The picture. `captured-ns`: its time of capture, as `select` has it",
        "headers": {"captured-ns": {"schema": {"type": "integer"}}},
        "content": {"image/jpeg": {}},
    });
    [
        ("/api/v1/status", get("The newest state", &[], &answers::<StatusSnapshot>("The state", sent))),
        (
            "/api/v1/control",
            get("Who controls, and who asks", &[], &answers::<ControlSeat>("The seat", sent)),
        ),
        (
            "/api/v1/picture.jpg",
            get(
                "The newest picture",
                &[query("overlay", "`true`: with the drawings of a film: box, ellipse and mode")],
                &json!({
                    "200": picture,
                    "400": said("Another query"),
                    "401": token_needed(),
                    "503": said("There is no picture yet; the text says how the video is"),
                }),
            ),
        ),
        (
            "/api/v1/requests",
            json!({"post": {
                "summary": requests,
                "requestBody": body::<RequestBody>(taken),
                "responses": answers::<Answer>("The answer", sent),
            }}),
        ),
        (
            "/api/v1/socket",
            json!({"get": {
                "summary": "The socket of a page",
                "description": socket,
                "responses": {"101": said("The socket is open"), "401": token_needed()},
            }}),
        ),
        (
            "/metrics",
            get(
                "Metrics for Prometheus",
                &[],
                &json!({"200": said("Text format 0.0.4"), "401": token_needed()}),
            ),
        ),
    ]
    .map(|(path, item)| (path.to_owned(), item))
    .to_vec()
}

/// Tokens, and whether the server answers.
fn access(sent: &mut SchemaGenerator) -> Vec<(String, Value)> {
    let healthz = json!({"get": {
        "summary": "Whether the server answers", "security": [], "responses": {"200": said("`ok`")},
    }});
    let login = json!({"post": {
        "summary": "A cookie for the token, for pages",
        "responses": {"204": said("The cookie is set"), "401": token_needed()},
    }});
    let access = get("What the token permits", &[], &answers::<AccessBody>("What it permits", sent));
    [("/api/v1/access", access), ("/api/v1/login", login), ("/healthz", healthz)]
        .map(|(path, item)| (path.to_owned(), item))
        .to_vec()
}

/// Links, and the pages that opened them.
fn links(sent: &mut SchemaGenerator) -> Vec<(String, Value)> {
    let with_refusals = |mut responses: Value, refusals: Value| {
        for (code, text) in [("401", token_needed()), ("403", said("The token is for watching"))] {
            responses[code] = text;
        }
        for (code, text) in refusals.as_object().into_iter().flatten() {
            responses[code] = text.clone();
        }
        responses
    };
    let read = with_refusals(answers::<LinksBody>("The links", sent), json!({}));
    let renewed = with_refusals(
        answers::<LinksBody>("The new links", sent),
        json!({"409": said("No token is asked for"), "500": said("There are no random numbers")}),
    );
    let code = with_refusals(
        json!({"200": {"description": "The picture", "content": {"image/svg+xml": {}}}}),
        json!({"404": said("Another name")}),
    );
    let signed_out = with_refusals(
        json!({"204": said("The page is signed out")}),
        json!({"404": said("No such page"), "409": said("It has no cookie")}),
    );
    let name = || path_parameter("name", "`control.svg` or `watch.svg`");
    [
        (
            "/api/v1/links",
            json!({
                "get": {"summary": "The links of the console", "responses": read},
                "post": {
                    "summary": "Makes new tokens; signs all other pages and programs out",
                    "responses": renewed,
                },
            }),
        ),
        ("/api/v1/links/{name}", get("A link as a QR code", &[name()], &code)),
        (
            "/api/v1/pages/{id}",
            json!({"delete": {
                "summary": "Signs a page out, with all pages of its browser",
                "parameters": [path_parameter("id", "The page's number, as in `/api/v1/control`")],
                "responses": signed_out,
            }}),
        ),
    ]
    .map(|(path, item)| (path.to_owned(), item))
    .to_vec()
}

/// The map under boat and marks.
fn map() -> (String, Value) {
    let answers = json!({
        "200": said("The tile: PNG, JPEG or WebP"), "204": said("The map has no such tile"),
        "401": token_needed(), "404": said("The program has no map"),
    });
    let places = ["zoom", "x", "y"].map(|name| path_parameter(name, "Web Mercator; y counts from the north"));
    ("/api/v1/map/{zoom}/{x}/{y}".to_owned(), get("A tile of the operator's map", &places, &answers))
}

/// The recordings of the folder.
fn recordings(sent: &mut SchemaGenerator, taken: &mut SchemaGenerator) -> Vec<(String, Value)> {
    let file = "`recording.mcap`, and once the film is made `annotated.mp4`, `report.html`, `video.mp4` and `trial.csv`";
    let found = json!({
        "200": said("The file"), "206": said("A part of it, as `Range` asked"), "400": said("No name of a recording"),
        "401": token_needed(), "404": said("No such file"),
    });
    let mut summary =
        answers::<Sortie>("The summary; of a recording that was cut off, of what is there", sent);
    summary["404"] = said("No such recording");
    summary["409"] = said("The recording is being written");
    summary["422"] = said("There is no summary; the text says why");
    let read = [
        (
            "/api/v1/recordings",
            get("The recordings, the newest first", &[], &answers::<Vec<Listed>>("The recordings", sent)),
        ),
        (
            "/api/v1/recordings/{name}/part/{from_ms}",
            json!({"get": {
                "summary": "Video and what the pilot made of it, from a moment on for a second or more; `?form=jpeg`",
                "parameters": [recording_name(), path_parameter("from_ms", "Milliseconds since the first step")],
                "responses": {
                    "200": said("Items: u32 length, little-endian; u8 kind (1 unit, 2 scene); content. `X-Next-Ms`: where the next part begins"),
                    "400": said("No name of a recording, or another query"), "401": token_needed(),
                    "404": said("No such recording, or one without an index"),
                    "409": said("A picture would have to be encoded while the camera is engaged"),
                },
            }}),
        ),
        (
            "/api/v1/recordings/{name}/sortie.json",
            get("The summary of a recording", &[recording_name()], &summary),
        ),
        (
            "/api/v1/recordings/{name}/thumbnail.jpg",
            get("A picture from the middle of a recording (JPEG)", &[recording_name()], &found),
        ),
        (
            "/api/v1/recordings/{name}/{file}",
            get("A file of a recording", &[recording_name(), path_parameter("file", file)], &found),
        ),
    ];
    read.into_iter().chain(changes_of_recordings(taken)).map(|(path, item)| (path.to_owned(), item)).collect()
}

fn recording_name() -> Value {
    path_parameter("name", "The recording, such as `run-2026-05-01-1.mcap`")
}

/// What renames, deletes and films.
fn changes_of_recordings(taken: &mut SchemaGenerator) -> [(&'static str, Value); 3] {
    let changed = |code: &str, text: &str| {
        json!({
            code: said(text),
            "400": said("No name of a recording"),
            "401": token_needed(),
            "403": said("The token is for watching"),
            "404": said("No such recording, or no folder of recordings"),
            "409": said("The camera is engaged, the recording is being written, or the name is taken"),
        })
    };
    [
        (
            "/api/v1/recordings/{name}",
            json!({"delete": {
                "summary": "Deletes a recording and its film", "parameters": [recording_name()],
                "responses": changed("204", "It is deleted"),
            }}),
        ),
        (
            "/api/v1/recordings/{name}/film",
            json!({"post": {
                "summary": "Begins to make film and table; the list says `being-made`, then `ready`",
                "parameters": [recording_name()],
                "responses": changed("202", "They are being made"),
            }}),
        ),
        (
            "/api/v1/recordings/{name}/name",
            json!({"post": {
                "summary": "Renames a recording", "parameters": [recording_name()],
                "requestBody": body::<NewName>(taken), "responses": changed("204", "It is renamed"),
            }}),
        ),
    ]
}

fn page(path: &str, summary: &str) -> Value {
    let parameters: Vec<Value> =
        path.contains("{name}").then(|| path_parameter("name", "The file")).into_iter().collect();
    json!({"get": {
        "summary": summary, "security": [], "parameters": parameters, "responses": {"200": said("The file")},
    }})
}

fn get(summary: &str, parameters: &[Value], responses: &Value) -> Value {
    json!({"get": {"summary": summary, "parameters": parameters, "responses": responses}})
}

fn query(name: &str, description: &str) -> Value {
    json!({"name": name, "in": "query", "description": description, "schema": {"type": "boolean"}})
}

fn path_parameter(name: &str, description: &str) -> Value {
    let schema = json!({"type": "string"});
    json!({"name": name, "in": "path", "required": true, "description": description, "schema": schema})
}

/// The schema of a type: a reference to its definition.
pub(super) fn reference<T: JsonSchema>(generator: &mut SchemaGenerator) -> Value {
    generator.subschema_for::<T>().to_value()
}

/// A JSON answer, or that a token is needed.
fn answers<T: JsonSchema>(description: &str, sent: &mut SchemaGenerator) -> Value {
    let schema = reference::<T>(sent);
    json!({
        "200": {"description": description, "content": {"application/json": {"schema": schema}}},
        "401": token_needed(),
    })
}

fn body<T: JsonSchema>(taken: &mut SchemaGenerator) -> Value {
    json!({"required": true, "content": {"application/json": {"schema": reference::<T>(taken)}}})
}

fn said(description: &str) -> Value {
    json!({"description": description})
}

fn token_needed() -> Value {
    said("A token is needed")
}
