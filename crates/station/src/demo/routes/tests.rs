//! The routes, called without a socket.

use std::future::Future;
use std::sync::mpsc::Receiver;

use axum::body::to_bytes;
use axum::http::{HeaderName, HeaderValue, Method};
use futures_util::StreamExt as _;
use tower::ServiceExt as _;

use super::*;

/// The address that the server under test listens on.
const HOST: &str = "127.0.0.1:8480";

/// A router, with the page's state and the queue of inputs behind it.
struct Server {
    router: Router,
    page: Arc<PageState>,
    inputs: Receiver<DriveInput>,
}

impl Server {
    fn on(address: &str) -> Self {
        let (page, inputs) = PageState::new();
        let page = Arc::new(page);
        let state = RouteState {
            picture_timeout: Duration::ZERO,
            ..RouteState::new(Arc::clone(&page), address.parse().unwrap())
        };
        Self { router: router(state), page, inputs }
    }

    async fn answer(&self, request: Request) -> Response {
        self.router.clone().oneshot(request).await.unwrap()
    }

    async fn get(&self, path: &str) -> Response {
        self.answer(request(Method::GET, path, &[(header::HOST, HOST)], "")).await
    }

    /// Status and text of the answer to a `POST`.
    async fn post(&self, path: &str, body: &str) -> (StatusCode, String) {
        let response = self.answer(request(Method::POST, path, &[(header::HOST, HOST)], body)).await;
        (response.status(), text(response).await)
    }
}

fn request(method: Method, path: &str, headers: &[(HeaderName, &'static str)], body: &str) -> Request {
    let mut request = Request::new(Body::from(body.to_owned()));
    *request.method_mut() = method;
    *request.uri_mut() = path.parse().unwrap();
    for (name, value) in headers {
        request.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    request
}

async fn text(response: Response) -> String {
    let bytes = to_bytes(response.into_body(), 1 << 20).await.unwrap();
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn run(test: impl Future<Output = ()>) {
    tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(test);
}

#[test]
fn the_page_is_served_with_its_security_headers() {
    run(async {
        let response = Server::on(HOST).get("/").await;
        assert_eq!(response.status(), StatusCode::OK);
        assert_eq!(response.headers()[header::CONTENT_TYPE], "text/html; charset=utf-8");
        assert_eq!(response.headers()[header::CACHE_CONTROL], "no-store");
        assert_eq!(response.headers()[header::X_CONTENT_TYPE_OPTIONS], "nosniff");
        let policy = response.headers()[header::CONTENT_SECURITY_POLICY].to_str().unwrap();
        assert!(policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"));
        assert_eq!(text(response).await, PAGE);
    });
}

#[test]
fn the_status_is_json() {
    run(async {
        let response = Server::on(HOST).get("/status").await;
        assert_eq!(response.headers()[header::CONTENT_TYPE], "application/json");
        assert_eq!(text(response).await, "{}");
    });
}

#[test]
fn a_picture_is_served_once_there_is_one() {
    run(async {
        let server = Server::on(HOST);
        assert_eq!(server.get("/picture.jpg").await.status(), StatusCode::SERVICE_UNAVAILABLE);
        server.page.set_picture(Bytes::from_static(b"a picture"));
        let response = server.get("/picture.jpg").await;
        assert_eq!(response.headers()[header::CONTENT_TYPE], "image/jpeg");
        assert_eq!(text(response).await, "a picture");
    });
}

#[test]
fn the_video_begins_with_the_last_picture_and_goes_on_with_the_newest() {
    run(async {
        let server = Server::on(HOST);
        server.page.set_picture(Bytes::from_static(b"first"));
        let response = server.get("/video").await;
        assert_eq!(response.headers()[header::CONTENT_TYPE], "multipart/x-mixed-replace; boundary=picture");
        let mut parts = response.into_body().into_data_stream();
        let first = parts.next().await.unwrap().unwrap();
        let head = "--picture\r\nContent-Type: image/jpeg\r\nContent-Length: 5\r\n\r\n";
        assert_eq!(first, format!("{head}first\r\n"));
        server.page.set_picture(Bytes::from_static(b"second"));
        server.page.set_picture(Bytes::from_static(b"third"));
        assert_eq!(parts.next().await.unwrap().unwrap(), format!("{head}third\r\n"));
    });
}

#[test]
fn the_video_has_a_limited_number_of_viewers_at_a_time() {
    run(async {
        let server = Server::on(HOST);
        let mut viewers = Vec::new();
        for _ in 0..MAX_VIEWERS {
            let response = server.get("/video").await;
            assert_eq!(response.status(), StatusCode::OK);
            viewers.push(response);
        }
        assert!(server.page.has_viewer());
        assert_eq!(server.get("/video").await.status(), StatusCode::SERVICE_UNAVAILABLE);
        viewers.pop();
        assert_eq!(server.get("/video").await.status(), StatusCode::OK);
    });
}

#[test]
fn inputs_of_the_page_are_queued_in_order() {
    run(async {
        let server = Server::on(HOST);
        for (path, body) in [
            ("/helm", r#"{"thrust": 0.5, "rudder": -1}"#),
            ("/do", r#"{"input": "engage"}"#),
            ("/do", r#"{"input": "stop"}"#),
            ("/do", r#"{"input": "pause"}"#),
            ("/do", r#"{"input": "resume"}"#),
            ("/do", r#"{"input": "helmsman"}"#),
        ] {
            assert_eq!(server.post(path, body).await, (StatusCode::NO_CONTENT, String::new()), "{body}");
        }
        let inputs: Vec<DriveInput> = server.inputs.try_iter().collect();
        assert_eq!(
            inputs,
            [
                DriveInput::Helm { thrust: 50, rudder: -100 },
                DriveInput::Engage,
                DriveInput::Stop,
                DriveInput::Pause,
                DriveInput::Resume,
                DriveInput::Helmsman,
            ]
        );
    });
}

#[test]
fn a_body_that_is_not_as_expected_is_refused_and_says_what_is() {
    run(async {
        let server = Server::on(HOST);
        for (path, body, expected) in [
            ("/helm", "", "thrust"),
            ("/helm", "{", "thrust"),
            ("/helm", r#"{"thrust": 0}"#, "thrust"),
            ("/helm", r#"{"thrust": 1.01, "rudder": 0}"#, "-1..1"),
            ("/helm", r#"{"thrust": null, "rudder": 0}"#, "-1..1"),
            ("/helm", r#"{"thrust": 0, "rudder": 0, "speed": 3}"#, "thrust"),
            ("/do", "engage", "{\"input\": \"engage\"}"),
            ("/do", r#"{"input": "take-off"}"#, "helmsman"),
            ("/do", r#"{"input": "helm", "thrust": 100, "rudder": 0}"#, "helmsman"),
        ] {
            let (status, answer) = server.post(path, body).await;
            assert_eq!(status, StatusCode::BAD_REQUEST, "{body}");
            assert!(answer.starts_with("expected ") && answer.contains(expected), "{body}: {answer}");
        }
        assert_eq!(server.inputs.try_iter().count(), 0);
    });
}

#[test]
fn a_body_that_is_too_long_is_refused() {
    run(async {
        let server = Server::on(HOST);
        let padded = |length: usize| format!("{:length$}", r#"{"input": "stop"}"#);
        assert_eq!(server.post("/do", &padded(MAX_BODY_BYTES)).await.0, StatusCode::NO_CONTENT);
        assert_eq!(server.post("/do", &padded(MAX_BODY_BYTES + 1)).await.0, StatusCode::PAYLOAD_TOO_LARGE);
        assert_eq!(server.inputs.try_iter().count(), 1);
    });
}

#[test]
fn a_full_input_queue_refuses_inputs_until_there_is_room() {
    run(async {
        let server = Server::on(HOST);
        let stop = r#"{"input": "stop"}"#;
        let mut queued = 0;
        let (status, answer) = loop {
            match server.post("/do", stop).await {
                (StatusCode::NO_CONTENT, _) => queued += 1,
                refused => break refused,
            }
            assert!(queued < 1000, "the queue has no bound");
        };
        assert_eq!((status, answer.as_str()), (StatusCode::SERVICE_UNAVAILABLE, "input queue full; retry\n"));
        assert_eq!(server.inputs.try_iter().count(), queued);
        assert_eq!(server.post("/do", stop).await.0, StatusCode::NO_CONTENT);
    });
}

#[test]
fn paths_and_methods_that_the_page_does_not_have_are_refused() {
    run(async {
        let server = Server::on(HOST);
        assert_eq!(server.get("/etc/passwd").await.status(), StatusCode::NOT_FOUND);
        assert_eq!(server.get("/helm").await.status(), StatusCode::METHOD_NOT_ALLOWED);
        assert_eq!(server.post("/video", "").await.0, StatusCode::METHOD_NOT_ALLOWED);
    });
}

/// A request with these headers, on every route, to a server on `address`.
async fn check_headers(address: &str, headers: &[(HeaderName, &'static str)], is_answered: bool) {
    for (method, path, body) in [
        (Method::GET, "/", ""),
        (Method::GET, "/status", ""),
        (Method::GET, "/picture.jpg", ""),
        (Method::GET, "/video", ""),
        (Method::POST, "/helm", r#"{"thrust": 1, "rudder": 0}"#),
        (Method::POST, "/do", r#"{"input": "engage"}"#),
    ] {
        let server = Server::on(address);
        let response = server.answer(request(method, path, headers, body)).await;
        let is_refused = response.status() == StatusCode::FORBIDDEN;
        assert_eq!(!is_refused, is_answered, "{path} of {address} with {headers:?}");
        if is_refused {
            assert_eq!(server.inputs.try_iter().count(), 0, "{path} with {headers:?}");
        }
    }
}

#[test]
fn only_its_own_page_and_scripts_of_this_machine_are_answered() {
    run(async {
        let own = "127.0.0.1:8480";
        for (headers, is_answered) in [
            (&[(header::HOST, own)][..], true),
            (&[(header::HOST, "localhost:8480"), (header::ORIGIN, "http://localhost:8480")], true),
            (&[(header::HOST, "[::1]:8480")], true),
            (&[], false),
            (&[(header::HOST, "rebound.example:8480")], false),
            (&[(header::HOST, "127.0.0.1:9999")], false),
            (&[(header::HOST, own), (header::ORIGIN, "http://evil.example")], false),
            (&[(header::HOST, own), (header::ORIGIN, "null")], false),
            (&[(header::HOST, own), (header::ORIGIN, "http://127.0.0.1:9999")], false),
        ] {
            check_headers(HOST, headers, is_answered).await;
        }
    });
}

#[test]
fn a_server_for_the_network_answers_to_any_host_but_to_its_own_page_only() {
    run(async {
        let anywhere = "192.0.2.7:8480";
        check_headers(anywhere, &[(header::HOST, "boat.example:8480")], true).await;
        let own = [(header::HOST, "boat.example:8480"), (header::ORIGIN, "http://boat.example:8480")];
        check_headers(anywhere, &own, true).await;
        let foreign = [(header::HOST, "boat.example:8480"), (header::ORIGIN, "http://evil.example")];
        check_headers(anywhere, &foreign, false).await;
        check_headers(anywhere, &[], false).await;
    });
}
