//! `barrelman check --discover`: the ONVIF cameras of the network.

use std::net::SocketAddr;

use barrelman_link_http::onvif::discovery::discover;
use barrelman_wire::onvif::discovery::FoundCamera;

use super::check_result::{CheckResult, Verdict};

/// Asks the cameras, and says what to give for each.
pub(super) fn check_discover(at: SocketAddr) -> Vec<CheckResult> {
    match discover(at) {
        Err(error) => {
            let details = format!("the question cannot be sent to {at}: {error}");
            vec![CheckResult::new("cameras", Verdict::Failed, details)]
        }
        Ok(cameras) if cameras.is_empty() => {
            let details = "none has answered in 2 s: cameras of another network, or with WS-Discovery \
                           switched off, are given by --link onvif://HOST";
            vec![CheckResult::new("cameras", Verdict::Warning, details)]
        }
        Ok(cameras) => cameras.iter().map(found_camera).collect(),
    }
}

fn found_camera(camera: &FoundCamera) -> CheckResult {
    let links: Vec<String> = camera.addresses.iter().map(|address| link_to(address)).collect();
    let name = if camera.name.is_empty() { "without a name" } else { &camera.name };
    let details = format!("{name}: --profile onvif-ptz --link {}", links.join(" or "));
    CheckResult::new("camera", Verdict::Ok, details)
}

/// The link to the camera with this address of its first service.
fn link_to(address: &str) -> String {
    let (scheme, rest) = match address.split_once("://") {
        Some(("https", rest)) => ("onvifs", rest),
        Some((_, rest)) => ("onvif", rest),
        None => ("onvif", address),
    };
    format!("{scheme}://{}", rest.split('/').next().unwrap_or_default())
}
