//! The page `/trust`: the certificate authority for a device that does not know it yet. No token is needed:
//! the certificate is public.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{MethodRouter, get};

use super::identity::Identity;

/// Where a device gets to know the authority.
#[derive(Debug, Clone, Copy)]
enum TrustFile {
    /// The page.
    Page,
    /// PEM.
    Pem,
    /// DER, which phones install.
    Der,
}

/// The routes of a server, of whose state `identity` gives the certificate.
pub(crate) fn routes<S: Send + Sync + 'static>(
    identity: fn(&S) -> Option<&Identity>,
) -> [(&'static str, MethodRouter<Arc<S>>); 3] {
    [("/trust", TrustFile::Page), ("/authority.pem", TrustFile::Pem), ("/authority.crt", TrustFile::Der)].map(
        |(path, file)| {
            (path, get(move |State(server): State<Arc<S>>| async move { response(identity(&server), file) }))
        },
    )
}

/// The answer with a file about the authority.
fn response(identity: Option<&Identity>, file: TrustFile) -> Response {
    let Some(authority) = identity.and_then(Identity::authority) else {
        return (StatusCode::NOT_FOUND, "this console has no certificate authority of its own\n")
            .into_response();
    };
    let as_file = |kind: &'static str, disposition: &'static str| -> [(HeaderName, &'static str); 2] {
        [(header::CONTENT_TYPE, kind), (header::CONTENT_DISPOSITION, disposition)]
    };
    match file {
        TrustFile::Page => {
            ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], page(&authority.fingerprint))
                .into_response()
        }
        TrustFile::Pem => {
            let headers = as_file("application/x-pem-file", "attachment; filename=\"barrelman.pem\"");
            (headers, authority.pem.clone()).into_response()
        }
        TrustFile::Der => {
            let headers = as_file("application/x-x509-ca-cert", "attachment; filename=\"barrelman.crt\"");
            (headers, authority.der.to_vec()).into_response()
        }
    }
}

fn page(fingerprint: &str) -> String {
    format!(
        r#"<!doctype html>
<html lang="en" data-theme="day">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Barrelman: trust this console</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/console/style.css">
<link rel="stylesheet" href="/console/help.css">
</head>
<body>
<div id="manual">
<nav><a href="/">Console</a></nav>
<main>
<h1>Trust this console</h1>
<p>The console has a certificate authority of its own. Its SHA-256:</p>
<pre id="fingerprint">{fingerprint}</pre>
<p>If the terminal shows the same SHA-256, download <a href="/authority.crt">the authority</a>
(<a href="/authority.pem">as PEM</a>), install it as a CA certificate in the settings of this device, and
compare the SHA-256 that the settings show.</p>
<p>Or, without installing anything: compare the SHA-256 of the authority in the browser's view of the
certificate, and go on.</p>
</main>
</div>
</body>
</html>
"#
    )
}
