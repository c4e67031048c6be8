//! The routes as a client sees them, on the real router: no test opens a socket.

use std::collections::BTreeSet;

use axum::body::Body;
use barrelman_vocab::{CameraRequest, OperatorRequest, VehicleRates};
use tower::ServiceExt as _;

use super::super::access::Role;
use super::super::in_memory::{
    CONTROL_TOKEN, DEMO, InMemory, LIVE, LIVE_OFF_LOOPBACK, Setup, WATCH_TOKEN, block_on,
};
use super::super::limits::REQUESTS;
use super::super::tokens::KeptTokens;
use super::*;
use crate::operator::SessionRequest;
use crate::test_scenes::{at, frame, idle};

const CONTROL: &str = "authorization: Bearer control-0123456789";
const WATCH: &str = "authorization: Bearer watch-0123456789ab";
const STOP: &str = r#"POST /api/v1/requests {"id":7,"request":{"kind":"stop"}}"#;
const ENGAGE: &str = r#"POST /api/v1/requests {"id":8,"request":{"kind":"engage"}}"#;

/// A request from its method, path and body in one line, and its headers. Unless they are given: the host is
/// loopback, and a body is JSON.
fn request(line: &str, headers: &[&str]) -> axum::http::Request<Body> {
    let mut words = line.splitn(3, ' ');
    let mut next = || words.next().unwrap_or_default();
    let (method, path, body) = (next(), next(), next());
    let has = |name: &str| headers.iter().any(|header| header.starts_with(name));
    let mut request = axum::http::Request::builder().method(method).uri(path);
    if !has("host: ") {
        request = request.header("host", "127.0.0.1:8480");
    }
    if !body.is_empty() && !has("content-type: ") {
        request = request.header("content-type", "application/json");
    }
    for header in headers {
        let (name, value) = header.split_once(": ").unwrap();
        request = request.header(name, value);
    }
    request.body(Body::from(body.to_owned())).unwrap()
}

/// The answer to a request, after the checks that every answer must pass.
#[track_caller]
fn call(session: &mut InMemory, line: &str, headers: &[&str]) -> (u16, String) {
    let (status, text) = session.call(request(line, headers));
    for header in [
        "cache-control: no-cache\n",
        "x-content-type-options: nosniff\n",
        "referrer-policy: no-referrer\n",
        "cross-origin-resource-policy: same-origin\n",
        "cross-origin-opener-policy: same-origin\n",
        "content-security-policy: default-src 'none'; ",
        "frame-ancestors 'none'",
    ] {
        assert!(text.contains(header), "{line}: {header:?} is not in\n{text}");
    }
    for word in [CONTROL_TOKEN, WATCH_TOKEN, "location: ", "access-control-", "unsafe-"] {
        assert!(!text.contains(word), "{line}: {word:?} is in\n{text}");
    }
    (status, text)
}

/// A request to a new console has this status, and an answer with these words.
#[track_caller]
fn check(setup: Setup, line: &str, headers: &[&str], status: u16, words: &[&str]) {
    let (got, text) = call(&mut InMemory::new(setup), line, headers);
    assert_eq!(got, status, "{line} {headers:?}\n{text}");
    for word in words {
        assert!(text.contains(word), "{line} {headers:?}: {word:?} is not in\n{text}");
    }
}

#[test]
fn the_page_is_served_to_everybody() {
    let html = "content-type: text/html; charset=utf-8\n";
    check(LIVE, "GET /", &[], 200, &[html, "\n\n<!doctype html>"]);
    check(LIVE_OFF_LOOPBACK, "GET /", &["host: 192.168.1.7:8480"], 200, &[html]);
    check(LIVE, "GET /?token=control", &[], 200, &[html]);
    check(LIVE, "HEAD /", &[], 200, &[html]);
    check(LIVE, "GET /console/main.js", &[], 200, &["content-type: text/javascript; charset=utf-8\n"]);
    check(LIVE, "GET /console/style.css", &[], 200, &["content-type: text/css; charset=utf-8\n"]);
    check(LIVE, "GET /console/index.html", &[], 200, &[html]);
    check(LIVE, "GET /healthz", &[], 200, &["content-type: text/plain", "\n\nok\n"]);
}

#[test]
fn every_file_of_the_page_is_served_unchanged() {
    let mut session = InMemory::new(LIVE);
    for (name, content) in files::FILES {
        let (status, text) = call(&mut session, &format!("GET /console/{name}"), &[]);
        assert_eq!(status, 200, "{name}");
        assert_eq!(text.split_once("\n\n").map(|(_, body)| body), Some(*content), "{name}");
    }
}

#[test]
fn no_other_file_is_served() {
    for path in [
        "/console/",
        "/console/absent.js",
        "/console/MAIN.JS",
        "/console/main.js/",
        "/console/./main.js",
        "/console/..",
        "/console/../Cargo.toml",
        "/console/../../etc/passwd",
        "/console/%2e%2e",
        "/console/%2e%2e%2fCargo.toml",
        "/console/..%2f..%2f..%2fetc%2fpasswd",
        "/console/%2fetc%2fpasswd",
        "/console/%252e%252e%252fCargo.toml",
        "/console/main.js%00",
        "/../Cargo.toml",
        "/%2e%2e/Cargo.toml",
        "//etc/passwd",
        "/index.html",
        "/api",
        "/api/v1",
        "/api/v1/",
        "/api/v1/../../healthz",
        "/api/v2/status",
        "/metrics/",
        "/favicon.ico",
    ] {
        check(LIVE, &format!("GET {path}"), &[CONTROL], 404, &[]);
    }
    check(LIVE, "GET /console/%ff", &[], 400, &[]);
}

#[test]
fn a_wrong_method_is_refused_and_the_right_one_is_named() {
    for (line, allowed) in [
        ("POST /", "GET,HEAD"),
        ("DELETE /console/main.js", "GET,HEAD"),
        ("PUT /healthz", "GET,HEAD"),
        ("POST /api/v1/access", "GET,HEAD"),
        ("GET /api/v1/login", "POST"),
        ("POST /api/v1/status", "GET,HEAD"),
        ("GET /api/v1/requests", "POST"),
        ("OPTIONS /api/v1/requests", "POST"),
        ("TRACE /metrics", "GET,HEAD"),
    ] {
        check(LIVE, line, &[CONTROL], 405, &[&format!("allow: {allowed}\n")]);
    }
}

#[test]
fn foreign_hosts_and_pages_are_refused_on_every_route() {
    let own_names = "this server answers to its own names only";
    let other_pages = "requests of other web pages are refused";
    for line in [
        "GET /",
        "GET /console/main.js",
        "GET /healthz",
        "GET /api/v1/access",
        "POST /api/v1/login",
        "GET /api/v1/status",
        STOP,
        "GET /api/v1/socket",
        "GET /metrics",
        "GET /absent",
        "PUT /healthz",
    ] {
        for (setup, own) in [
            (LIVE, "host: 127.0.0.1:8480"),
            (LIVE_OFF_LOOPBACK, "host: 192.168.1.7:8480"),
            (DEMO, "host: localhost:8480"),
        ] {
            check(setup, line, &[CONTROL, "host: evil.example:8480"], 403, &[own_names]);
            check(setup, line, &[CONTROL, own, "origin: http://evil.example"], 403, &[other_pages]);
            check(setup, line, &[CONTROL, own, "origin: null"], 403, &[other_pages]);
            check(setup, line, &[CONTROL, own, "sec-fetch-site: cross-site"], 403, &[other_pages]);
            check(setup, line, &[CONTROL, own, "sec-fetch-site: same-site"], 403, &[other_pages]);
        }
    }
    check(LIVE, "GET /api/v1/status", &[CONTROL, "host: 192.168.1.7:8480"], 403, &[own_names]);
}

#[test]
fn a_refused_page_changes_nothing() {
    let mut session = InMemory::new(DEMO);
    for header in ["host: evil.example:8480", "origin: http://evil.example", "sec-fetch-site: cross-site"] {
        call(&mut session, STOP, &[header]);
        call(&mut session, ENGAGE, &[header]);
        call(&mut session, "POST /api/v1/login", &[header]);
    }
    assert_eq!(session.console.gateway.stop_latch().pending(), None);
    session.take_requests();
    assert_eq!(session.taken, []);
}

#[test]
fn requests_of_the_page_itself_are_answered() {
    let own = "origin: http://127.0.0.1:8480";
    check(LIVE, "GET /api/v1/status", &[CONTROL, own, "sec-fetch-site: same-origin"], 200, &[]);
    check(LIVE, "GET /api/v1/status", &[CONTROL, "sec-fetch-site: none"], 200, &[]);
    let boat = ["host: boat.example:8480", "origin: http://boat.example:8480", CONTROL];
    check(LIVE_OFF_LOOPBACK, "GET /api/v1/status", &boat, 200, &[]);
}

#[test]
fn a_link_elsewhere_may_open_the_page_and_nothing_else() {
    let opened = ["sec-fetch-site: cross-site", "sec-fetch-mode: navigate", "sec-fetch-dest: document"];
    check(LIVE, "GET /", &opened, 200, &[]);
    check(LIVE, "POST /", &opened, 403, &[]);
    check(LIVE, "GET /api/v1/status", &[&opened[..], &[CONTROL]].concat(), 403, &[]);
    check(LIVE, "GET /", &[opened[0], opened[1], "sec-fetch-dest: iframe"], 403, &[]);
    check(LIVE, "GET /", &[opened[0], "sec-fetch-mode: no-cors", "sec-fetch-dest: image"], 403, &[]);
}

#[test]
fn without_a_token_nothing_is_told_and_nothing_is_done() {
    for line in
        ["GET /api/v1/access", "POST /api/v1/login", "GET /api/v1/status", "GET /metrics", STOP, ENGAGE]
    {
        for headers in [
            &[][..],
            &["authorization: Bearer control-012345678"],
            &["authorization: Bearer control-01234567890"],
            &["authorization: Bearer "],
            &["authorization: control-0123456789"],
            &["authorization: Basic control-0123456789"],
            &["cookie: barrelman-8480=control-0123456789"],
            &["cookie: barrelman-8480="],
            &["x-token: control-0123456789"],
        ] {
            check(LIVE, line, headers, 401, &["www-authenticate: Bearer\n", "a token is needed"]);
        }
    }
    for query in ["?token=control-0123456789", "?access_token=control-0123456789"] {
        check(LIVE, &format!("GET /api/v1/status{query}"), &[], 401, &[]);
        check(LIVE, &STOP.replacen(" {", &format!("{query} {{"), 1), &[], 401, &[]);
    }
    let mut session = InMemory::new(LIVE);
    call(&mut session, STOP, &[]);
    assert_eq!(session.console.gateway.stop_latch().pending(), None, "a stop needs a token, too");
}

#[test]
fn a_demo_on_loopback_asks_for_no_token() {
    check(DEMO, "GET /api/v1/access", &[], 200, &[r#"{"may_control":true,"may_stop":true}"#]);
    check(DEMO, "GET /api/v1/status", &[], 200, &[r#""step":0"#]);
    check(DEMO, "GET /metrics", &[], 200, &[]);
    check(DEMO, ENGAGE, &[], 200, &[r#"{"id":8,"answer":"accepted"}"#]);
    check(DEMO, STOP, &[], 200, &[r#"{"id":7,"answer":"accepted"}"#]);
    check(DEMO, "POST /api/v1/login", &[], 204, &["set-cookie: barrelman-8480="]);
}

#[test]
fn the_status_is_json_and_the_metrics_are_text() {
    let json = "content-type: application/json\n";
    check(LIVE, "GET /api/v1/status", &[WATCH], 200, &[json, r#""mode":{"name":"idle","#, r#""law":null"#]);
    let metrics = "content-type: text/plain; version=0.0.4\n";
    check(LIVE, "GET /metrics", &[WATCH], 200, &[metrics, "# TYPE barrelman_steps_total counter\n"]);
    let mut session = InMemory::new(LIVE);
    session.step(&idle(at(40)));
    let (_, text) = call(&mut session, "GET /api/v1/status", &[CONTROL]);
    assert!(text.contains(r#"{"step":1,"at_ns":40000000,"#), "{text}");
}

#[test]
fn the_document_names_every_route_and_every_method() {
    let document = crate::api::api_document();
    let documented: BTreeSet<(String, String)> =
        document["paths"].as_object().unwrap().iter().flat_map(of_path).collect();
    let mut session = InMemory::new(LIVE);
    let mut served = BTreeSet::new();
    for (path, _) in routes() {
        let line = format!("TRACE {}", path.replace("{name}", "a.mcap").replace("{file}", "trial.csv"));
        let (status, text) = call(&mut session, &line, &[CONTROL]);
        assert_eq!(status, 405, "{line}");
        let allowed = text.lines().find_map(|line| line.strip_prefix("allow: ")).unwrap();
        let methods = allowed.split(',').filter(|method| *method != "HEAD");
        served.extend(methods.map(|method| (path.to_owned(), method.to_lowercase())));
    }
    assert_eq!(documented, served);
}

/// The path and the methods of an item of the document.
fn of_path((path, item): (&String, &serde_json::Value)) -> Vec<(String, String)> {
    item.as_object().unwrap().keys().map(|method| (path.clone(), method.clone())).collect()
}

#[test]
fn the_newest_picture_is_a_jpeg_file_that_nobody_keeps() {
    let mut session = InMemory::new(LIVE);
    let ask = |session: &InMemory, line: &str, token: &str| {
        let router = router(Arc::clone(&session.console));
        let answer = block_on(router.oneshot(request(line, &[token]))).unwrap();
        let header = |name: &str| answer.headers().get(name).map(|value| value.to_str().unwrap().to_owned());
        (answer.status().as_u16(), header("content-type"), header("cache-control"), header("captured-ns"))
    };
    let plain = "GET /api/v1/picture.jpg";
    let (status, text) = session.call(request(plain, &[WATCH]));
    assert_eq!(status, 503);
    assert!(text.contains("there is no picture yet: the video is "), "{text}");
    session.console.videos.first.pictures.put(&frame(1, at(40)), &idle(at(41)), VehicleRates::REST);
    let jpeg = |captured: &str| {
        let text = |text: &str| Some(text.to_owned());
        (200, text("image/jpeg"), text("no-store"), text(captured))
    };
    assert_eq!(ask(&session, plain, WATCH), jpeg("40000000"));
    assert_eq!(ask(&session, "GET /api/v1/picture.jpg?overlay=true", WATCH), jpeg("40000000"));
    assert_eq!(ask(&session, "GET /api/v1/picture.jpg?overlay=1", WATCH).0, 400);
    assert_eq!(session.call(request(plain, &[])).0, 401);
}

#[test]
fn requests_are_taken_from_the_control_token_and_a_stop_from_both() {
    let (accepted, refused) = (r#""answer":"accepted""#, r#""answer":"refused""#);
    check(LIVE, ENGAGE, &[CONTROL], 200, &["content-type: application/json\n", r#"{"id":8,"#, accepted]);
    check(LIVE, ENGAGE, &[WATCH], 200, &[refused, "this token may only watch and stop"]);
    check(LIVE, STOP, &[CONTROL], 200, &[r#"{"id":7,"answer":"accepted"}"#]);
    check(LIVE, STOP, &[WATCH], 200, &[r#"{"id":7,"answer":"accepted"}"#]);

    let mut session = InMemory::new(LIVE);
    call(&mut session, ENGAGE, &[WATCH]);
    call(&mut session, STOP, &[WATCH]);
    assert_eq!((session.taken.as_slice(), session.console.gateway.stop_latch().taken()), (&[][..], 1));
    call(&mut session, ENGAGE, &[CONTROL]);
    assert_eq!(session.taken, [SessionRequest::Pilot(OperatorRequest::Camera(CameraRequest::Engage))]);
}

#[test]
fn a_program_gives_way_to_a_page_in_control_but_stops_the_camera() {
    let mut session = InMemory::new(LIVE);
    session.join("a", Role::Control);
    assert!(call(&mut session, ENGAGE, &[CONTROL]).1.contains("a page is in control"));
    assert!(call(&mut session, STOP, &[CONTROL]).1.contains("accepted"));
    assert_eq!(session.taken, []);
}

#[test]
fn a_body_that_cannot_be_read_is_refused_with_the_reason() {
    let post = |body: &str| format!("POST /api/v1/requests {body}");
    for (body, reason) in [
        ("{", "the request cannot be read: EOF"),
        ("[]", "the request cannot be read"),
        ("{}", "missing field `request`"),
        ("null", "the request cannot be read"),
        (r#"{"request":"stop"}"#, "the request cannot be read"),
        (r#"{"request":{}}"#, "missing field `kind`"),
        (
            r#"{"request":{"kind":"take-off"}}"#,
            "there is no request of the kind `take-off`: use one of stop, select, ",
        ),
        (r#"{"request":{"kind":"Stop"}}"#, "there is no request of the kind `Stop`"),
        (r#"{"request":{"kind":"stop"},"token":"x"}"#, "unknown field `token`"),
        (r#"{"id":-1,"request":{"kind":"stop"}}"#, "invalid value"),
        (r#"{"request":{"kind":"nudge","pan":1}}"#, "missing field `tilt`"),
        (r#"{"request":{"kind":"nudge","pan":"1","tilt":0}}"#, "invalid type"),
        (r#"{"request":{"kind":"nudge","pan":1,"tilt":0,"speed":9}}"#, "unknown field `speed`"),
        (r#"{"request":{"kind":"law","law":"fastest"}}"#, "unknown variant `fastest`"),
        (
            r#"{"request":{"kind":"select","bounds":{"u":1,"v":2,"w":3},"captured_ns":0}}"#,
            "missing field `h`",
        ),
        (r#"{"request":{"kind":"note","text":"two\nlines"}}"#, "the text of a note is one line"),
        (r#"{"request":{"kind":"engage","law":"eco"}}"#, "unknown field `law`"),
        (r#"{"request":{"kind":"stop"}} {}"#, "trailing characters"),
        ("\u{feff}{}", "the request cannot be read"),
    ] {
        check(LIVE, &post(body), &[CONTROL], 400, &[reason, "see `barrelman config api`"]);
    }
    let deep = format!(r#"{{"request":{{"pan":{}{}}}}}"#, "[".repeat(2000), "]".repeat(2000));
    check(LIVE, &post(&deep), &[CONTROL], 400, &["recursion limit exceeded"]);
}

#[test]
fn a_body_has_at_most_4096_bytes() {
    let padded = |bytes: usize| {
        let body = STOP.rsplit(' ').next().unwrap();
        format!("POST /api/v1/requests {body}{}", " ".repeat(bytes - body.len()))
    };
    check(LIVE, &padded(4096), &[CONTROL], 200, &["accepted"]);
    check(LIVE, &padded(4097), &[CONTROL], 413, &[]);
    check(LIVE, &padded(1 << 20), &[CONTROL], 413, &[]);
}

/// A request of which only the head comes.
fn head(line: &str, headers: &[&str]) -> axum::http::Request<Body> {
    let nothing = futures_util::stream::pending::<Result<Bytes, std::io::Error>>();
    request(line, headers).map(|_| Body::from_stream(nothing))
}

#[test]
fn who_asks_is_checked_before_the_body_is_read() {
    for line in ["POST /api/v1/requests", "POST /api/v1/login"] {
        assert_eq!(InMemory::new(LIVE).call(head(line, &[])).0, 401, "{line}");
    }
    assert_eq!(InMemory::new(LIVE).call(head("POST /api/v1/login", &[WATCH])).0, 204);
    let form = "content-type: text/plain";
    assert_eq!(InMemory::new(LIVE).call(head("POST /api/v1/requests", &[CONTROL, form])).0, 415);
}

#[test]
fn a_body_that_does_not_come_in_time_is_refused_and_ends_the_connection() {
    let head = head("POST /api/v1/requests", &[CONTROL]);
    let refused = block_on(body_within(head, Duration::ZERO)).unwrap_err();
    assert_eq!(refused.status(), StatusCode::REQUEST_TIMEOUT);
    assert_eq!(refused.headers()[header::CONNECTION], "close");
    assert!(block_on(body_within(request(STOP, &[]), Duration::ZERO)).is_ok(), "it came with the head");
}

#[test]
fn a_body_that_a_foreign_form_could_send_is_refused() {
    for kind in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "multipart/form-data",
        "json",
        "application/json-evil",
        "application/jsonx; charset=utf-8",
        "application/json+x",
        "application/json, text/plain",
        "text/plain; application/json",
        "application/ json",
        "",
    ] {
        check(LIVE, STOP, &[CONTROL, &format!("content-type: {kind}")], 415, &["application/json"]);
    }
    check(LIVE, "POST /api/v1/requests", &[CONTROL], 415, &["send Content-Type: application/json"]);
    for kind in [
        "application/json; charset=utf-8",
        "application/json;charset=utf-8",
        "Application/JSON",
        "application/json ;a=b",
    ] {
        check(LIVE, STOP, &[CONTROL, &format!("content-type: {kind}")], 200, &["accepted"]);
    }
}

#[test]
fn a_header_that_says_one_thing_comes_once_and_is_text() {
    for header in [
        "host: 127.0.0.1:8480",
        "host: evil.example",
        "origin: http://127.0.0.1:8480",
        "content-type: application/json",
        "authorization: Bearer guess",
        "sec-fetch-site: same-origin",
    ] {
        let name = header.split(':').next().unwrap();
        let own = ["host: 127.0.0.1:8480", "origin: http://127.0.0.1:8480", "content-type: application/json"];
        let mut headers = vec![CONTROL, "sec-fetch-site: same-origin"];
        headers.extend(own);
        check(LIVE, STOP, &headers, 200, &["accepted"]);
        headers.push(header);
        check(LIVE, STOP, &headers, 400, &[&format!("send the header {name} once")]);
    }
    let mut session = InMemory::new(LIVE);
    let mut request = request(STOP, &[CONTROL]);
    request.headers_mut().insert("origin", HeaderValue::from_bytes(b"http://\xff").unwrap());
    assert_eq!(session.call(request).0, 400, "an origin that is no text is not the same as none");
    assert_eq!(session.console.gateway.stop_latch().taken(), 0);
}

/// Takes all that the limit of a role permits, for ever: the bucket is filled up to a time that does not
/// come.
fn exhaust(session: &InMemory, role: Role) {
    let never = at(1 << 40);
    assert!(session.console.access.permits_request(role, REQUESTS.burst, never));
}

#[test]
fn a_watcher_who_asks_too_often_is_refused_and_neither_the_operator_nor_a_stop_is() {
    let mut session = InMemory::new(LIVE);
    assert_eq!(call(&mut session, "GET /api/v1/status", &[WATCH]).0, 200);
    exhaust(&session, Role::Watch);
    for line in
        ["GET /api/v1/status", "GET /metrics", "GET /", "POST /api/v1/login", "GET /api/v1/socket", ENGAGE]
    {
        let (status, text) = call(&mut session, line, &[WATCH]);
        assert!(status == 429 && text.contains("connection: close\n"), "{line}: {status} {text}");
    }
    for _ in 0..1000 {
        let (status, text) = call(&mut session, STOP, &[WATCH]);
        assert!(status == 200 && text.contains("accepted") && text.contains("connection: close\n"), "{text}");
    }
    assert_eq!(session.console.gateway.stop_latch().taken(), 1000);
    assert_eq!(call(&mut session, ENGAGE, &[CONTROL]).0, 200);
    exhaust(&session, Role::Control);
    assert_eq!(call(&mut session, ENGAGE, &[CONTROL]).0, 429, "the operator's limit is the operator's own");
    assert_eq!(call(&mut session, STOP, &[CONTROL]).0, 200);
}

#[test]
fn a_socket_needs_an_upgrade() {
    check(LIVE, "GET /api/v1/socket", &[CONTROL], 400, &[]);
    check(LIVE, "POST /api/v1/socket", &[CONTROL], 405, &["allow: GET,HEAD\n"]);
}

/// Exchanges a token for a cookie, as name and value.
fn log_in(session: &mut InMemory, token: &str) -> String {
    let (status, text) = call(session, "POST /api/v1/login", &[token]);
    assert_eq!(status, 204, "{text}");
    assert!(text.ends_with("\n\n"), "the answer has no body\n{text}");
    let cookies: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("set-cookie: ")).collect();
    let [cookie] = cookies[..] else { panic!("one cookie is set: {cookies:?}") };
    let (pair, attributes) = cookie.split_once("; ").unwrap();
    let attributes: BTreeSet<_> = attributes.split("; ").collect();
    assert!(attributes.is_superset(&["HttpOnly", "SameSite=Strict", "Path=/"].into()), "{cookie}");
    assert!(pair.starts_with("barrelman-8480="), "cookies do not differ by port: {cookie}");
    pair.to_owned()
}

#[test]
fn a_token_is_exchanged_for_a_cookie_with_the_same_role() {
    for (token, may_control) in [(CONTROL, true), (WATCH, false)] {
        let mut session = InMemory::new(LIVE);
        let cookie = format!("cookie: theme=night; {}", log_in(&mut session, token));
        let (status, text) = call(&mut session, "GET /api/v1/access", &[&cookie]);
        assert_eq!(status, 200);
        assert!(text.ends_with(&format!(r#"{{"may_control":{may_control},"may_stop":true}}"#)), "{text}");
        call(&mut session, ENGAGE, &[&cookie]);
        assert_eq!(session.taken.len(), usize::from(may_control));
        assert!(call(&mut session, STOP, &[&cookie]).1.contains("accepted"));
    }
}

#[test]
fn the_watch_link_leaves_the_control_to_a_browser_that_has_it() {
    let mut session = InMemory::new(LIVE);
    let cookie = format!("cookie: {}", log_in(&mut session, CONTROL));
    let (status, text) = call(&mut session, "POST /api/v1/login", &[WATCH, &cookie]);
    assert!(status == 204 && !text.contains("set-cookie"), "{text}");
    let watching = format!("cookie: {}", log_in(&mut session, WATCH));
    let (_, text) = call(&mut session, "POST /api/v1/login", &[CONTROL, &watching]);
    assert!(
        text.contains("set-cookie"),
        "the control link gives the control to a browser that watched\n{text}"
    );
}

#[test]
fn a_token_that_is_not_known_is_refused_whatever_the_cookie_permits() {
    let mut session = InMemory::new(LIVE);
    let cookie = format!("cookie: {}", log_in(&mut session, CONTROL));
    let wrong = "authorization: Bearer not-the-token";
    assert_eq!(call(&mut session, "POST /api/v1/login", &[wrong, &cookie]).0, 401);
    assert_eq!(call(&mut session, "POST /api/v1/login", &[&cookie]).0, 204, "the cookie alone is enough");
}

#[test]
fn a_cookie_is_valid_under_its_own_name_and_on_its_own_server_only() {
    let mut session = InMemory::new(LIVE);
    let cookie = log_in(&mut session, CONTROL);
    let value = cookie.split_once('=').unwrap().1;
    let status = |session: &mut InMemory, header: &str| call(session, "GET /api/v1/access", &[header]).0;
    assert_eq!(status(&mut session, &format!("cookie: {cookie}")), 200);
    assert_eq!(status(&mut session, &format!("cookie: barrelman-8481={value}")), 401);
    assert_eq!(status(&mut session, &format!("cookie: {cookie}x")), 401);
    assert_eq!(status(&mut session, &format!("authorization: Bearer {value}")), 401);
    assert_eq!(status(&mut InMemory::new(LIVE), &format!("cookie: {cookie}")), 401);
    let foreign = [&*format!("cookie: {cookie}"), "origin: http://evil.example"];
    assert_eq!(call(&mut session, STOP, &foreign).0, 403, "a cookie does not help a foreign page");
    assert_ne!(cookie, log_in(&mut session, CONTROL), "each page gets a cookie of its own");
}

#[test]
fn a_stop_is_answered_once_the_pilot_has_taken_it() {
    let InMemory { console, publisher, .. } = InMemory::new(LIVE);
    let router = router(Arc::clone(&console));
    drop(publisher);
    let answered = block_on(tower::ServiceExt::oneshot(router, request(STOP, &[CONTROL]))).unwrap();
    let body = block_on(axum::body::to_bytes(answered.into_body(), 4096)).unwrap();
    let text = std::str::from_utf8(&body).unwrap();
    assert!(text.contains("refused") && text.contains("the ground station's own stop"), "{text}");
    assert_eq!(console.gateway.stop_latch().pending(), Some(1), "the press stays");
}

#[test]
fn a_page_that_missed_a_renewal_by_age_can_still_stop_and_nothing_else() {
    let mut session = InMemory::new(LIVE);
    let cookie = format!("cookie: {}", log_in(&mut session, CONTROL));
    let access = &session.console.access;
    session.console.links.renew_by_age(access, Vec::new).unwrap();
    assert_eq!(call(&mut session, ENGAGE, &[&cookie]).0, 401);
    assert_eq!(call(&mut session, STOP, &[&cookie]).0, 200);
    assert_eq!(session.console.gateway.stop_latch().taken(), 1);
    assert_eq!(call(&mut session, "GET /api/v1/status", &[&cookie]).0, 401);
    let (status, text) = call(&mut session, "GET /api/v1/access", &[&cookie]);
    assert_eq!((status, text.contains(r#"{"may_control":false,"may_stop":true}"#)), (401, true), "{text}");
    // New links end what may have become known.
    session.console.links.renew(&session.console.access, &[]).unwrap();
    assert_eq!(call(&mut session, STOP, &[&cookie]).0, 401);
}

#[test]
fn new_links_that_cannot_be_written_are_told_with_what_to_do() {
    let file = std::env::temp_dir().join(format!("barrelman-new-links-{}", std::process::id()));
    std::fs::create_dir_all(&file).unwrap();
    let mut session = InMemory::with_kept(LIVE, KeptTokens { file: Some(file.clone()), max_age: None });
    let (status, text) = session.call(request("POST /api/v1/links", &[CONTROL]));
    std::fs::remove_dir(&file).unwrap();
    assert_eq!(status, 200, "{text}");
    let words = [
        "all other pages are signed out",
        "after a restart",
        file.to_str().unwrap(),
        "choose New links again",
    ];
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
    let control = session.console.access.tokens().unwrap().control;
    assert!(control != CONTROL_TOKEN && text.contains(&control), "{text}");
    assert!(session.logged("links-renewed")[0].contains("after a restart"));
}
